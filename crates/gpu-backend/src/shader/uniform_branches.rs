//! No pass over view rays, froxels or faces of shadow volumes branches on uniforms alone: lavapipe compiles a shader anew for
//! their values, in every dispatch, as long as that halves it.

use naga::{AddressSpace, Block, Expression, Function, Handle, Module, Statement};

use super::{PASSES, assemble};

/// What a value depends on, the most varied part of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    Constant,
    Uniform,
    Other,
}

fn source(module: &Module, function: &Function, expression: Handle<Expression>) -> Source {
    let of = |expression| source(module, function, expression);
    match function.expressions[expression] {
        Expression::Literal(_)
        | Expression::Constant(_)
        | Expression::Override(_)
        | Expression::ZeroValue(_) => Source::Constant,
        Expression::GlobalVariable(variable) => match module.global_variables[variable].space {
            AddressSpace::Uniform => Source::Uniform,
            _ => Source::Other,
        },
        Expression::Access { base, index } => of(base).max(of(index)),
        Expression::AccessIndex { base, .. } => of(base),
        Expression::Load { pointer } => of(pointer),
        Expression::Splat { value, .. } => of(value),
        Expression::Swizzle { vector, .. } => of(vector),
        Expression::Compose { ref components, .. } => {
            components.iter().map(|&part| of(part)).max().unwrap_or(Source::Constant)
        }
        Expression::Unary { expr, .. } | Expression::As { expr, .. } => of(expr),
        Expression::Binary { left, right, .. } => of(left).max(of(right)),
        Expression::Select { condition, accept, reject } => of(condition).max(of(accept)).max(of(reject)),
        Expression::Relational { argument, .. } => of(argument),
        Expression::Math { arg, arg1, arg2, arg3, .. } => {
            [Some(arg), arg1, arg2, arg3].into_iter().flatten().map(of).max().unwrap_or(Source::Other)
        }
        _ => Source::Other,
    }
}

/// The conditions of all branches of a block.
fn conditions(block: &Block, found: &mut Vec<Handle<Expression>>) {
    for statement in block {
        match statement {
            Statement::Block(inner) => conditions(inner, found),
            Statement::If { condition, accept, reject } => {
                found.push(*condition);
                conditions(accept, found);
                conditions(reject, found);
            }
            Statement::Switch { selector, cases } => {
                found.push(*selector);
                cases.iter().for_each(|case| conditions(&case.body, found));
            }
            Statement::Loop { body, continuing, break_if } => {
                found.extend(*break_if);
                conditions(body, found);
                conditions(continuing, found);
            }
            _ => (),
        }
    }
}

/// The lines of a shader that branch on uniforms alone.
fn offending(text: &str) -> Vec<String> {
    let module = naga::front::wgsl::parse_str(text).unwrap();
    let functions = module.functions.iter().map(|(_, function)| function);
    let mut lines = Vec::new();
    for function in functions.chain(module.entry_points.iter().map(|entry| &entry.function)) {
        let mut found = Vec::new();
        conditions(&function.body, &mut found);
        for condition in found.into_iter().filter(|&at| source(&module, function, at) == Source::Uniform) {
            let line = function.expressions.get_span(condition).location(text).line_number as usize;
            lines.push(text.lines().nth(line - 1).unwrap_or_default().trim().to_owned());
        }
    }
    lines
}

#[test]
fn passes_do_not_branch_on_uniforms_alone() {
    let folders = ["scatter/", "sample/", "froxel/", "volume/", "frame/"];
    for pass in PASSES.iter().filter(|pass| folders.iter().any(|folder| pass.name.starts_with(folder))) {
        let lines = offending(&assemble(pass.name).unwrap());
        assert!(lines.is_empty(), "{}: {lines:#?}", pass.name);
    }
}

#[test]
fn such_branches_are_found() {
    let with = |condition: &str| {
        offending(&format!(
            "struct Light {{ adds: u32, radius: f32 }}
             @group(0) @binding(0) var<uniform> light: Light;
             override LIGHT: u32 = 0u;
             fn f(x: f32) -> f32 {{
                 if {condition} {{
                     return 1.0;
                 }}
                 return x;
             }}"
        ))
    };
    assert_eq!(with("light.adds == 1u").len(), 1);
    assert_eq!(
        with("light.radius < 0.0 || x > 1.0").len(),
        1,
        "the second is asked in a branch on the first"
    );
    assert!(with("(light.radius < 0.0) | (x > 1.0)").is_empty() && with("x < light.radius").is_empty());
    assert!(with("LIGHT == 1u").is_empty(), "known to the pipeline");
}
