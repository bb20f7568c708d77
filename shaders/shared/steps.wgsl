// The steps of a march: equal ones where the ray ends; along an infinite ray equal angles at a local light, equal
// transmittance under a directional one. Twin: `Piece::steps` in crates/hybrid-march/src/brute_force.rs.

#import light

struct Steps {
    piece: vec2f,
    kind: u32,      // one of the constants below
    x_foot: f32,
    h: f32,
    angle: f32,     // of the piece's start, seen from the light
    turn: f32,      // from there to the angle of its end
}

const EQUAL_STEPS: u32 = 0u;
const EQUAL_ANGLES: u32 = 1u;
const EQUAL_TRANSMITTANCE: u32 = 2u;

// The angle of x from the foot, in (-pi/2, pi/2).
fn angle_at(x: f32, x_foot: f32, h: f32) -> f32 {
    let a = x - x_foot;
    return select(1.0, -1.0, a < 0.0) * accurate_angle(abs(a), h);
}

fn steps_of(foot: Foot, piece: vec2f, angles: bool, directional: bool) -> Steps {
    let infinite = piece.y >= 1e29;
    var kind = EQUAL_STEPS;
    if directional && infinite {
        kind = EQUAL_TRANSMITTANCE;
    } else if !directional && (angles || infinite) {
        kind = EQUAL_ANGLES;
    }
    var angle = 0.0;
    var turn = 0.0;
    if kind == EQUAL_ANGLES {
        angle = angle_at(piece.x, foot.x_foot, foot.h);
        turn = select(angle_at(piece.y, foot.x_foot, foot.h), HALF_PI, infinite) - angle;
    }
    return Steps(piece, kind, foot.x_foot, foot.h, angle, turn);
}

// The distance at a share of the piece, in the measure in which its steps are equal.
fn share_at(steps: Steps, t: f32) -> f32 {
    if steps.kind == EQUAL_STEPS {
        return steps.piece.x + (steps.piece.y - steps.piece.x) * t;
    }
    if steps.kind == EQUAL_TRANSMITTANCE {
        return steps.piece.x - accurate_log(1.0 - t) / view.least_extinction;
    }
    if t == 0.0 {
        return steps.piece.x;
    }
    return steps.x_foot + steps.h * accurate_tan(steps.angle + steps.turn * t);
}

// The distance at which step `i` begins; the middle of step i is at i + 0.5.
fn step_at(steps: Steps, i: f32) -> f32 {
    let count = f32(light.samples);
    if i >= count {
        return steps.piece.y;
    }
    return share_at(steps, i / count);
}
