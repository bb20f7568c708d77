//! The media mathematics against reference values with proven digits, within the accuracy that its documentation
//! promises.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests, which clippy does not take for tests"
)]

use airlight_tests::cases::{
    self, AirlightCase, AirlightFile, DifferenceCase, FCase, FFile, HoffmanPreethamCase, HoffmanPreethamFile,
    NastyFile, RayCase, RayFile,
};
use media_math::{
    Boundary, Foot, HoffmanPreetham, HomogeneousMedium, MieNormalisation, PhaseFunction, Real, airlight,
    airlight_over, signed_airlight, sun_f, sun_f_difference,
};

/// Optical depth up to which f32 holds its relative bar; beyond, the rounding of the exponent takes over.
const DEPTH_OF_BAR: f64 = 60.0;

/// Counts cases, and keeps the worst and every failure.
#[derive(Default)]
struct Tally {
    checked: usize,
    underflown: usize,
    worst: (f64, String),
    failures: Vec<String>,
}

impl Tally {
    /// Holds `got` against `exact` in a type whose least normal number is `least`.
    fn check(&mut self, name: &str, got: f64, exact: f64, bar: f64, least: f64) {
        if exact == 0.0 {
            self.checked += 1;
            if got != 0.0 {
                self.failures.push(format!("{name}: {got:e} instead of 0"));
            }
            return;
        }
        if exact.abs() < least {
            self.underflown += 1;
            // the smallest normal number itself may come out of a value just below it
            if !(got.abs() <= least * (1.0 + bar)) {
                self.failures.push(format!("{name}: {got:e}, but {exact:e} is below the type's range"));
            }
            return;
        }
        self.checked += 1;
        self.record(name, (got / exact - 1.0).abs(), bar);
    }

    /// Holds an error against a bar.
    fn record(&mut self, name: &str, error: f64, bar: f64) {
        let share = error / bar;
        if share > self.worst.0 {
            self.worst = (share, format!("{name}: {error:.2e}, bar {bar:.2e}"));
        }
        if !(error <= bar) {
            self.failures.push(format!("{name}: error {error:.3e}, bar {bar:.3e}"));
        }
    }

    fn finish(self, what: &str, at_least: usize) {
        println!(
            "{what}: {} checked, {} underflow, worst {:.0} % of its bar ({})",
            self.checked,
            self.underflown,
            100.0 * self.worst.0,
            self.worst.1
        );
        assert!(self.checked >= at_least, "{what}: only {} cases were checked", self.checked);
        assert!(self.failures.is_empty(), "{what}:\n{}", self.failures.join("\n"));
    }
}

fn medium<T: Real>(kappa_s: f64, kappa_t: f64) -> HomogeneousMedium<T> {
    HomogeneousMedium::with_extinction(T::lit(kappa_s), T::lit(kappa_t)).unwrap()
}

fn foot<T: Real>(x_foot: f64, h: f64) -> Foot<T> {
    Foot { x_foot: T::lit(x_foot), h: T::lit(h) }
}

fn check_airlight(cases: &[AirlightCase], at_least: usize) {
    let (mut wide, mut narrow) = (Tally::default(), Tally::default());
    for case in cases {
        if let Some(exact) = case.foot.value {
            let got = airlight(
                &medium::<f64>(case.kappa_s, case.kappa_t),
                &case.phase.function(None),
                case.intensity,
                &foot(case.foot.x_foot, case.foot.h),
                case.x0,
                case.x1,
            );
            wide.check(&case.id, got, exact, 1e-12, f64::MIN_POSITIVE);
        }
        if let Some(block) = &case.f32
            && let Some(exact) = block.value
        {
            let got = airlight(
                &medium::<f32>(block.kappa_s, block.kappa_t),
                &case.phase.function(block.g),
                block.intensity as f32,
                &foot(block.x_foot, block.h),
                block.x0 as f32,
                block.x1 as f32,
            );
            let depth = block.kappa_t * (block.x0 + (block.x0 - block.x_foot).hypot(block.h));
            let bar = 1e-5 * (depth / DEPTH_OF_BAR).max(1.0);
            narrow.check(&case.id, got.into(), exact, bar, f32::MIN_POSITIVE.into());
        }
    }
    wide.finish("airlight, f64", at_least);
    narrow.finish("airlight, f32", at_least);
}

fn check_f(values: &[FCase], differences: &[DifferenceCase], at_least: usize) {
    let mut tally = Tally::default();
    for case in values {
        let name = format!("F({:e}, {:e})", case.u, case.v);
        tally.check(&name, sun_f(case.u, case.v), case.value, 1e-13, f64::MIN_POSITIVE);
    }
    tally.finish("F, f64", at_least);
    let mut tally = Tally::default();
    for case in differences {
        let name = format!("F({:e}, {:e}..{:e})", case.u, case.v0, case.v1);
        let got = sun_f_difference(case.u, case.v0, case.v1);
        tally.check(&name, got, case.value, 1e-12, f64::MIN_POSITIVE);
    }
    tally.finish("differences of F, f64", at_least);
}

/// Airlight over a ray's lit intervals.
fn paired<T: Real>(ray: &RayCase) -> f64 {
    let lit = ray.lit_intervals.iter().map(|&[a, b]| (T::lit(a), T::lit(b)));
    let sum = airlight_over(
        &medium::<T>(ray.kappa_s, ray.kappa_t),
        &ray.phase.function(None),
        T::lit(ray.intensity),
        &foot(ray.x_foot, ray.h),
        lit,
    );
    sum.widen()
}

/// The same as a signed sum over boundaries in an order without meaning.
fn signed(ray: &RayCase) -> f64 {
    let mut boundaries: Vec<Boundary<f32>> =
        ray.lit_intervals.iter().flat_map(|&[a, b]| Boundary::of_interval(a as f32, b as f32)).collect();
    boundaries.sort_by_key(|boundary| boundary.distance.to_bits().wrapping_mul(0x9E37_79B9));
    let medium = medium::<f32>(ray.kappa_s, ray.kappa_t);
    let foot = foot(ray.x_foot, ray.h);
    signed_airlight(&medium, &ray.phase.function(None), ray.intensity as f32, &foot, boundaries).into()
}

fn check_rays(rays: &[RayCase], at_least: usize) {
    let (mut wide, mut narrow, mut unordered) = (Tally::default(), Tally::default(), Tally::default());
    for (i, ray) in rays.iter().enumerate() {
        let name = format!("ray {i}, {}, {} intervals", ray.category, ray.lit_intervals.len());
        wide.check(&name, paired::<f64>(ray), ray.value, 1e-12, f64::MIN_POSITIVE);
        let start = ray.lit_intervals.first().map_or(0.0, |interval| interval[0]);
        let depth = ray.kappa_t * (start + (start - ray.x_foot).hypot(ray.h));
        let bar = 1e-5 * (depth / DEPTH_OF_BAR).max(1.0);
        narrow.check(&name, paired::<f32>(ray), ray.value, bar, f32::MIN_POSITIVE.into());
        if ray.unshadowed_value >= f32::MIN_POSITIVE.into() {
            unordered.checked += 1;
            unordered.record(&name, (signed(ray) - ray.value).abs() / ray.unshadowed_value, 2e-5);
        }
    }
    wide.finish("shadowed rays, f64", at_least);
    narrow.finish("shadowed rays, f32", at_least);
    unordered.finish("signed sums, f32", at_least);
}

/// Transmittance, inscatter and radiance, by channel.
fn directional<T: Real>(case: &HoffmanPreethamCase) -> [[f64; 3]; 3] {
    let normalisation = match case.mie_normalisation.as_str() {
        "hoffman_preetham" => MieNormalisation::HoffmanPreetham,
        _ => MieNormalisation::Standard,
    };
    let channels = |v: [f64; 3]| v.map(T::lit);
    let model = HoffmanPreetham::<T, [T; 3]>::new(
        channels(case.beta_rayleigh),
        channels(case.beta_mie),
        channels(case.beta_absorption),
        T::lit(case.g),
        normalisation,
    )
    .unwrap();
    let lit = case.lit_intervals.iter().map(|&[a, b]| (T::lit(a), T::lit(b)));
    let f_ex = model.extinction_factor(T::lit(case.s));
    let l_in = model.in_scatter(T::lit(case.cos_theta), channels(case.e_sun), lit);
    let l0 = channels(case.l0);
    let l = [0, 1, 2].map(|c| l0[c] * f_ex[c] + l_in[c]);
    [f_ex, l_in, l].map(|spectrum| spectrum.map(T::widen))
}

fn check_directional(cases: &[HoffmanPreethamCase], at_least: usize) {
    let (mut wide, mut narrow) = (Tally::default(), Tally::default());
    for (i, case) in cases.iter().enumerate() {
        let (in_f64, in_f32) = (directional::<f64>(case), directional::<f32>(case));
        let exact = [("f_ex", case.f_ex), ("l_in", case.l_in), ("l", case.l)];
        for (k, (field, exact)) in exact.into_iter().enumerate() {
            for (c, exact) in exact.into_iter().enumerate() {
                let name = format!("case {i}, {}, {field}[{c}]", case.category);
                let beta = case.beta_rayleigh[c] + case.beta_mie[c] + case.beta_absorption[c];
                let bar = 1e-5 * (beta * case.s / DEPTH_OF_BAR).max(1.0);
                wide.check(&name, in_f64[k][c], exact, 1e-12, f64::MIN_POSITIVE);
                narrow.check(&name, in_f32[k][c], exact, bar, f32::MIN_POSITIVE.into());
            }
        }
    }
    wide.finish("directional light, f64", at_least);
    narrow.finish("directional light, f32", at_least);
}

#[test]
fn airlight_of_intervals() {
    check_airlight(&cases::read::<AirlightFile>("airlight_public.json").cases, 500);
}

#[test]
fn sun_s_f_and_its_differences() {
    let file: FFile = cases::read("F_public.json");
    check_f(&file.f, &file.difference, 100);
}

#[test]
fn airlight_of_shadowed_rays() {
    check_rays(&cases::read::<RayFile>("multi_interval_public.json").rays, 50);
}

#[test]
fn hoffman_and_preetham_s_model() {
    let file: HoffmanPreethamFile = cases::read("hoffman_preetham_public.json");
    check_directional(&file.cases, 300);
}

#[test]
fn nasty_cases() {
    let file: NastyFile = cases::read("nasty.json");
    check_airlight(&file.airlight, 20);
    check_f(&file.f, &file.difference, 5);
    check_rays(&file.rays, 5);
    check_directional(&file.hoffman_preetham, 50);
}

/// The order in which an interval's form is picked must not leave a seam: a whole is the sum of its parts.
#[test]
fn an_interval_is_the_sum_of_its_parts() {
    let file: AirlightFile = cases::read("airlight_public.json");
    let mut checked = 0;
    for case in file.cases.iter().filter(|case| case.x1 > case.x0 && case.phase.is_isotropic()) {
        let medium = medium::<f64>(case.kappa_s, case.kappa_t);
        let foot = foot::<f64>(case.foot.x_foot, case.foot.h);
        let over = |x0, x1| airlight(&medium, &PhaseFunction::ISOTROPIC, case.intensity, &foot, x0, x1);
        let whole = over(case.x0, case.x1);
        // the inputs of a part are rounded, which a sliver would feel
        let middle = 0.5 * (case.x0 + case.x1);
        if whole < 1e-280 || case.x1 - case.x0 < 1e-3 * case.x1 {
            continue;
        }
        let parts = over(case.x0, middle) + over(middle, case.x1);
        assert!((parts / whole - 1.0).abs() < 2e-12, "{}: {parts:e} {whole:e}", case.id);
        checked += 1;
    }
    assert!(checked > 200, "only {checked} cases");
}
