// Airlight of a lit piece of a view ray in a homogeneous medium, three channels.
//
// The importing pass declares the override constants `LIGHT`, `TEXTURED`, `ACHROMATIC` (the channels are attenuated
// alike, so one is integrated) and `ISOTROPIC`, and where it takes textured lights the texture `picture`.
// Twins: crates/media-math/src/optics/{airlight,composite,directional}.rs, crates/ground-truth/src/airlight.rs.

#import light

// A light and a ray, with what is the same for all pieces.
struct Lamp {
    foot: LightFoot,
    direction: vec3f, // of the view ray, unit
    sun_phase: f32,   // phase value of a directional light; units: 1/sr
    middle: vec2f,    // piece of the ray inside a spot's inner cone
}

fn lobe_of(index: u32) -> Lobe {
    let lobe = view.lobes[index];
    return Lobe(u32(lobe.y), lobe.z);
}

// Phase value for the unit vectors to the light and along the view ray; units: 1/sr.
fn phase_between(to_light: vec3f, direction: vec3f) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < lobe_count(); i++) {
        sum += view.lobes[i].x * lobe_between(lobe_of(i), to_light, direction);
    }
    return sum;
}

// Phase value at path excess r and light offset h; units: 1/sr.
fn phase_at(r: f32, h: f32) -> f32 {
    if ISOTROPIC {
        return INV_4PI;
    }
    var sum = 0.0;
    for (var i = 0u; i < lobe_count(); i++) {
        sum += view.lobes[i].x * lobe_at(lobe_of(i), r, h);
    }
    return sum;
}

fn lamp_of(ray: ViewRay) -> Lamp {
    let foot = light_foot(ray);
    var sun_phase = 0.0;
    if LIGHT == DIRECTIONAL {
        sun_phase = phase_between(-light.axis, ray.direction);
    }
    var middle = vec2f();
    if LIGHT == SPOT {
        let all = vec2f(0.0, ENDLESS);
        middle = cone_piece(foot, light.axis, ray.direction, light.cos_inner * light.cos_inner, all);
    }
    return Lamp(foot, ray.direction, sun_phase, middle);
}

// Integral of p e^(-sigma_t (R - R0))/d^2 over a span, in its unit of length.
fn phase_integral(span: Span, sigma_t: f32) -> f32 {
    if ISOTROPIC {
        return isotropic_integral(span, sigma_t);
    }
    var sum = 0.0;
    for (var i = 0u; i < lobe_count(); i++) {
        let lobe = lobe_of(i);
        if lobe.kind == ISOTROPIC_LOBE {
            sum += view.lobes[i].x * isotropic_integral(span, sigma_t);
        } else {
            sum += view.lobes[i].x * lobe_integral(span, sigma_t, lobe);
        }
    }
    return sum;
}

// e^(-sigma_t (x0 + d0)) in two halves: each is representable long after the whole is not.
fn half_transmittance(span: Span) -> vec3f {
    if ACHROMATIC {
        return vec3f(exp(-0.5 * view.sigma_t.x * span.unit * span.near));
    }
    return exp(-0.5 * view.sigma_t * (span.unit * span.near));
}

// A light of constant intensity: the interval form.
fn constant_airlight(lamp: Lamp, power: vec3f, x0: f32, x1: f32) -> vec3f {
    let span = span_of(lamp.foot.foot, x0, x1);
    var integral: vec3f;
    if ACHROMATIC {
        integral = vec3f(phase_integral(span, view.sigma_t.x * span.unit));
    } else {
        for (var c = 0; c < 3; c++) {
            integral[c] = phase_integral(span, view.sigma_t[c] * span.unit);
        }
    }
    let half = half_transmittance(span);
    return ((view.sigma_s * power) * half) * (integral / span.unit) * half;
}

// Colour of a spot's picture towards w.
fn picture_colour(w: vec3f) -> vec3f {
    if !TEXTURED {
        return vec3f(1.0);
    }
    let size = vec2i(textureDimensions(picture));
    let at = picture_coordinates(w) * vec2f(size);
    // the nearest texel is all four; no branch on a uniform alone: see pixels.wgsl
    let is_nearest = light.nearest_texel == 1u;
    let corner = floor(at - select(0.5, 0.0, is_nearest));
    let f = select(at - 0.5 - corner, vec2f(), is_nearest);
    let low = clamp(vec2i(corner), vec2i(0), size - 1);
    let high = clamp(vec2i(corner) + select(1, 0, is_nearest), vec2i(0), size - 1);
    let upper = mix(textureLoad(picture, low, 0).rgb, textureLoad(picture, vec2i(high.x, low.y), 0).rgb, f.x);
    let lower = mix(textureLoad(picture, vec2i(low.x, high.y), 0).rgb, textureLoad(picture, high, 0).rgb, f.x);
    return mix(upper, lower, f.y);
}

// The vector from a light to the point at distance x.
fn away_from(lamp: Lamp, x: f32) -> vec3f {
    return lamp.foot.from_light + (x - lamp.foot.foot.x_foot) * lamp.direction;
}

// A spot's intensity towards the point at distance x; units: W/sr.
fn spot_intensity(lamp: Lamp, x: f32) -> vec3f {
    let w = away_from(lamp, x);
    return spot_falloff(w) * picture_colour(w) * light.power;
}

// A piece on which a spot's intensity is smooth, by the composite rule: also where it does not vary, since a second form
// for that would cost its time on drivers that execute both sides of a branch.
fn varying_airlight(lamp: Lamp, x0: f32, x1: f32) -> vec3f {
    let span = span_of(lamp.foot.foot, x0, x1);
    let sigma_t = view.sigma_t * span.unit;
    let least = select(min(sigma_t.x, min(sigma_t.y, sigma_t.z)), sigma_t.x, ACHROMATIC);
    var feature = 1.0;
    if !ISOTROPIC {
        for (var i = 0u; i < lobe_count(); i++) {
            feature = min(feature, lobe_feature(lobe_of(i)));
        }
    }
    let panels = panels_of(span, least, feature);
    let count = node_count(panels);
    let half = half_transmittance(span);
    if ACHROMATIC && !TEXTURED {
        // the channels differ by factors alone
        var grey = 0.0;
        for (var i = 0; i < count; i++) {
            let node = path_node(span, panels, i);
            let r = span.r0 + node.delta;
            let x = lamp.foot.foot.x_foot + 0.5 * (r - span.h * (span.h / r)) * span.unit;
            let falloff = spot_falloff(away_from(lamp, clamp(x, x0, x1)));
            grey += node.weight * phase_at(r, span.h) * exp(-sigma_t.x * node.delta) * falloff;
        }
        return (view.sigma_s * light.power * half) * (grey / span.unit) * half;
    }
    var sum = vec3f();
    for (var i = 0; i < count; i++) {
        let node = path_node(span, panels, i);
        let r = span.r0 + node.delta;
        let x = lamp.foot.foot.x_foot + 0.5 * (r - span.h * (span.h / r)) * span.unit;
        let weight = node.weight * phase_at(r, span.h);
        sum += weight * exp(-sigma_t * node.delta) * spot_intensity(lamp, clamp(x, x0, x1));
    }
    return (view.sigma_s * half) * (sum / span.unit) * half;
}

// Where the ray passes from one texel of a spot's picture to the next, after x; at the centres' planes where the
// picture is interpolated between them.
fn next_texel(lamp: Lamp, x: f32) -> f32 {
    let size = vec2f(textureDimensions(picture));
    let shift = select(0.5, 0.0, light.nearest_texel == 1u);
    let w0 = lamp.foot.from_light - lamp.foot.foot.x_foot * lamp.direction;
    let depth = light.tan_outer * vec2f(dot(w0, light.axis), dot(lamp.direction, light.axis));
    let aside = vec2f(dot(w0, light.right), dot(lamp.direction, light.right));
    let upward = vec2f(dot(w0, light.top), dot(lamp.direction, light.top));
    var next = ENDLESS;
    for (var axis = 0; axis < 2; axis++) {
        let n = select(size.y, size.x, axis == 0);
        let line = 0.5 * n * (depth + select(-upward, aside, axis == 0)) - shift * depth;
        let growth = line.y * depth.x - line.x * depth.y;
        if growth == 0.0 {
            continue;
        }
        let here = (line.x + line.y * x) / max(depth.x + depth.y * x, 1e-30);
        // the border ahead; one that rounding puts behind is passed over
        var index = select(ceil(here) - 1.0, floor(here) + 1.0, growth > 0.0);
        for (var k = 0; k < 2; k++) {
            let border = line - index * depth;
            let root = -border.x / border.y;
            if root > x * 1.000001 {
                if border.y != 0.0 {
                    next = min(next, root);
                }
                break;
            }
            index += sign(growth);
        }
    }
    return next;
}

// Light that arrives unattenuated and alike everywhere on a piece, scattered with one phase value.
fn sunlit_airlight(phase: f32, power: vec3f, x0: f32, x1: f32) -> vec3f {
    let length = x1 - x0;
    var path: vec3f;
    for (var c = 0; c < 3; c++) {
        let sigma_t = view.sigma_t[c];
        if length > 1e29 {
            path[c] = exp(-sigma_t * x0) / max(sigma_t, 1e-30);
        } else {
            path[c] = exp(-sigma_t * x0) * length * phi(sigma_t * length);
        }
    }
    // a channel without a medium has an infinite path to infinity, and still no airlight
    let scattered = select(view.sigma_s * path, vec3f(), view.sigma_s == vec3f());
    return phase * scattered * power;
}

// Airlight of a lit piece; units: W/(m^2 sr).
fn piece_airlight(lamp: Lamp, x0: f32, x1: f32) -> vec3f {
    if !(x1 > x0) {
        return vec3f();
    }
    if LIGHT == DIRECTIONAL {
        return sunlit_airlight(lamp.sun_phase, light.power, x0, x1);
    }
    if LIGHT == POINT {
        return constant_airlight(lamp, light.power, x0, x1);
    }
    // a spot's intensity is smooth between the edges of its inner cone, and the texels of its picture
    let near = clamp(lamp.middle.x, x0, x1);
    let far = clamp(lamp.middle.y, near, x1);
    var sum = vec3f();
    var x = x0;
    for (var i = 0; i < 4096; i++) {
        var next = x1;
        if TEXTURED {
            next = min(next_texel(lamp, x), x1);
        }
        next = select(next, near, near > x && near < next);
        next = select(next, far, far > x && far < next);
        sum += varying_airlight(lamp, x, next);
        x = next;
        if x >= x1 {
            break;
        }
    }
    return sum;
}
