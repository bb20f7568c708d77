//! What was left out of the scene, gathered so that a thousand like cases make one sentence.

/// Notes in the order of their first case.
#[derive(Debug, Default)]
pub(super) struct Notes(Vec<Note>);

#[derive(Debug)]
struct Note {
    what: &'static str,
    first: String,
    more: usize,
}

impl Notes {
    /// Notes that `what` befell the object called `place`.
    pub(super) fn add(&mut self, what: &'static str, place: &str) {
        match self.0.iter_mut().find(|note| note.what == what) {
            Some(note) => note.more += 1,
            None => self.0.push(Note { what, first: place.into(), more: 0 }),
        }
    }

    /// One sentence a kind of note.
    pub(super) fn into_sentences(self) -> Vec<String> {
        let sentence = |note: Note| match note.more {
            0 => format!("{}: {}", note.first, note.what),
            more => format!("{} and {more} more: {}", note.first, note.what),
        };
        self.0.into_iter().map(sentence).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn like_cases_are_one_sentence() {
        let mut notes = Notes::default();
        for place in ["light 0", "light 1", "light 2"] {
            notes.add("its range is ignored", place);
        }
        notes.add("is skipped", "camera 0");
        assert_eq!(
            notes.into_sentences(),
            ["light 0 and 2 more: its range is ignored", "camera 0: is skipped"]
        );
    }
}
