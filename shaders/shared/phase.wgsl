// Phase functions, a lobe at a time. Twin: crates/media-math/src/optics/phase.rs.

const INV_4PI: f32 = 0.0795774715;

const ISOTROPIC_LOBE: u32 = 0u;
const RAYLEIGH_LOBE: u32 = 1u;
const HENYEY_GREENSTEIN_LOBE: u32 = 2u;
const HOFFMAN_PREETHAM_MIE_LOBE: u32 = 3u;

struct Lobe {
    kind: u32,
    g: f32, // asymmetry in (-1, 1)
}

// What a Henyey-Greenstein kernel is scaled by.
fn lobe_scale(lobe: Lobe) -> f32 {
    if lobe.kind == HOFFMAN_PREETHAM_MIE_LOBE {
        return INV_4PI * (1.0 - lobe.g) * (1.0 - lobe.g);
    }
    return INV_4PI * (1.0 - lobe.g) * (1.0 + lobe.g);
}

// Phase value at path excess r and light offset h; units: 1/sr.
fn lobe_at(lobe: Lobe, r: f32, h: f32) -> f32 {
    if lobe.kind == ISOTROPIC_LOBE {
        return INV_4PI;
    }
    // the cosine of the scattering angle is (1 - r2)/(1 + r2)
    let rh = r / h;
    let r2 = min(rh * rh, 1e30);
    if lobe.kind == RAYLEIGH_LOBE {
        let c = (1.0 - r2) / (1.0 + r2);
        return 0.75 * INV_4PI * (1.0 + c * c);
    }
    let g = lobe.g;
    let ratio = (1.0 + r2) / ((1.0 - g) * (1.0 - g) + (1.0 + g) * (1.0 + g) * r2);
    return lobe_scale(lobe) * ratio * sqrt(ratio);
}

// Phase value for the unit vectors to the light and along the view ray; units: 1/sr.
//
// 1 -+ cos comes from the difference of the vectors: a rounded dot product has no digits left near the light.
fn lobe_between(lobe: Lobe, to_light: vec3f, view: vec3f) -> f32 {
    if lobe.kind == ISOTROPIC_LOBE {
        return INV_4PI;
    }
    if lobe.kind == RAYLEIGH_LOBE {
        let c = dot(to_light, view);
        return 0.75 * INV_4PI * (1.0 + c * c);
    }
    let g = lobe.g;
    let apart = to_light - sign(g) * view;
    let near = 1.0 - abs(g);
    let denominator = near * near + abs(g) * dot(apart, apart);
    return lobe_scale(lobe) / (denominator * sqrt(denominator));
}

// Where the lobe changes fastest along a view ray, as a multiple of h in the path excess.
fn lobe_feature(lobe: Lobe) -> f32 {
    let peaked = lobe.kind == HENYEY_GREENSTEIN_LOBE || lobe.kind == HOFFMAN_PREETHAM_MIE_LOBE;
    return select(1.0, (1.0 - lobe.g) / (1.0 + lobe.g), peaked && lobe.g > 0.0);
}
