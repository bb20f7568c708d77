// The steps of a march: equal ones where the ray ends; along an infinite ray equal angles at a local light, equal
// transmittance under a directional one. Twin: `Piece::steps` in crates/hybrid-march/src/brute_force.rs.

#import light

struct Steps {
    piece: vec2f,
    kind: u32,      // one of the constants below
    x_foot: f32,
    h: f32,
    side: f32,      // of the foot that the piece is on: 1 behind it, -1 before it, 0 on both
    angle: f32,     // of the piece's start, seen from the light: from the foot, or from the ray's end on that side
    turn: f32,      // from there to the angle of its end
}

const EQUAL_STEPS: u32 = 0u;
const EQUAL_ANGLES: u32 = 1u;
const EQUAL_TRANSMITTANCE: u32 = 2u;

// The angle of a point of the ray, `a` behind the foot: from the foot in (-pi/2, pi/2) for a piece on both of its sides. On
// one side it is measured from the ray's end there, which is far away: where a ray leads straight to the light that angle
// is tiny, and its digits, which are all that tells points apart, would be lost beside pi/2.
fn angle_at(a: f32, h: f32, side: f32) -> f32 {
    if side != 0.0 {
        return accurate_angle(h, abs(a));
    }
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
    let a = piece - foot.x_foot;
    let side = select(select(0.0, -1.0, a.y < 0.0), 1.0, a.x > 0.0);
    var angle = 0.0;
    var turn = 0.0;
    if kind == EQUAL_ANGLES {
        angle = angle_at(a.x, foot.h, side);
        let end = select(HALF_PI, 0.0, side != 0.0);
        turn = select(angle_at(a.y, foot.h, side), end, infinite) - angle;
    }
    return Steps(piece, kind, foot.x_foot, foot.h, side, angle, turn);
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
    let tangent = accurate_tan(steps.angle + steps.turn * t);
    return steps.x_foot + steps.h * select(tangent, steps.side / max(tangent, 1e-30), steps.side != 0.0);
}

// The distance at which step `i` begins; the middle of step i is at i + 0.5.
fn step_at(steps: Steps, i: f32) -> f32 {
    let count = f32(light.samples);
    if i >= count {
        return steps.piece.y;
    }
    return share_at(steps, i / count);
}
