//! Why a command failed, and the exit code that says so.

/// A failed command; its text becomes the single line on stderr.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Bad input or usage, naming the file or flag: exit code 2.
    Input(String),
    /// The program itself failed, or a check did not hold: exit code 1.
    Program(String),
}

impl Failure {
    /// Bad input; `what` names the file or flag.
    pub(crate) fn input(what: impl std::fmt::Display) -> Self {
        Self::Input(what.to_string())
    }

    /// A failure of the program.
    pub(crate) fn program(what: impl std::fmt::Display) -> Self {
        Self::Program(what.to_string())
    }

    /// Exit code of the command.
    pub(crate) fn code(&self) -> u8 {
        match self {
            Self::Input(_) => 2,
            Self::Program(_) => 1,
        }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (Self::Input(what) | Self::Program(what)) = self;
        // one line, whatever a library put into its message
        let mut words = what.split_whitespace();
        if let Some(first) = words.next() {
            f.write_str(first)?;
        }
        words.try_for_each(|word| write!(f, " {word}"))
    }
}

/// What a command returns.
pub(crate) type Outcome<T = ()> = Result<T, Failure>;
