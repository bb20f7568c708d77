//! The shadow of a triangle on a view ray: one interval, found analytically.
//!
//! The triangle cuts the plane of ray and light in a segment. What of the segment lies between the ray and the light
//! is projected from the light onto the ray; the shadow is what lies between the projections of its ends.

use glam::DVec2;
use scene::Interval;

use crate::ray_plane::Source;

/// Shadow on the ray of the segment `ends` in the ray's plane; `None` if the segment does not come between.
#[inline]
pub(crate) fn shadow_of(source: &Source, ends: [DVec2; 2]) -> Option<Interval> {
    // just below the light its projection is as far away as it gets
    let ceiling = match source {
        Source::Near(foot) => foot.h * (1.0 - 1e-12),
        Source::Far { .. } => f64::INFINITY,
    };
    let [low, high] = if ends[0].y <= ends[1].y { ends } else { [ends[1], ends[0]] };
    if high.y <= 0.0 || low.y >= ceiling {
        return None;
    }
    let at_height = |v: f64| low.lerp(high, (v - low.y) / (high.y - low.y));
    let a = if low.y < 0.0 { at_height(0.0) } else { low };
    let b = if high.y > ceiling { at_height(ceiling) } else { high };
    let project = |p: DVec2| match *source {
        Source::Near(foot) => {
            foot.x_foot + (p.x - foot.x_foot) * (foot.h / (foot.h - p.y.clamp(0.0, ceiling)))
        }
        Source::Far { along, across } => p.x - p.y.max(0.0) * (along / across),
    };
    let (a, b) = (project(a), project(b));
    Some(Interval::new(a.min(b), a.max(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use media_math::Foot;

    fn near(x_foot: f64, h: f64) -> Source {
        Source::Near(Foot { x_foot, h })
    }

    #[test]
    fn halfway_up_doubles_the_width() {
        let shadow = shadow_of(&near(0.0, 2.0), [DVec2::new(-1.0, 1.0), DVec2::new(0.5, 1.0)]).unwrap();
        assert_eq!(shadow, Interval::new(-2.0, 1.0));
    }

    #[test]
    fn what_is_not_between_casts_nothing() {
        assert!(shadow_of(&near(0.0, 2.0), [DVec2::new(-1.0, -1.0), DVec2::new(1.0, -0.1)]).is_none());
        assert!(shadow_of(&near(0.0, 2.0), [DVec2::new(-1.0, 2.5), DVec2::new(1.0, 3.0)]).is_none());
    }

    #[test]
    fn a_segment_through_the_ray_is_clipped_at_it() {
        // vertical at u = 1 from below the ray to half the light's height
        let shadow = shadow_of(&near(0.0, 2.0), [DVec2::new(1.0, -5.0), DVec2::new(1.0, 1.0)]).unwrap();
        assert!((shadow.start - 1.0).abs() < 1e-15 && (shadow.end - 2.0).abs() < 1e-15);
    }

    #[test]
    fn a_segment_past_the_light_shadows_to_infinity() {
        let shadow = shadow_of(&near(0.0, 2.0), [DVec2::new(1.0, 0.0), DVec2::new(1.0, 9.0)]).unwrap();
        assert!(shadow.start == 1.0 && shadow.end > 1e11);
    }

    #[test]
    fn parallel_light_shifts() {
        // light from straight above, then from 45 degrees ahead
        let ends = [DVec2::new(1.0, 3.0), DVec2::new(2.0, 3.0)];
        let above = Source::Far { along: 0.0, across: 1.0 };
        assert_eq!(shadow_of(&above, ends).unwrap(), Interval::new(1.0, 2.0));
        let ahead = Source::Far { along: 0.5_f64.sqrt(), across: 0.5_f64.sqrt() };
        assert_eq!(shadow_of(&ahead, ends).unwrap(), Interval::new(-2.0, -1.0));
    }
}
