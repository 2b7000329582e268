//! Two directions: a curve in a cone.
//!
//! Slipping elements turn: each one goes back onto the cone along the exact path of an element under a straight slip,
//! and where the direction changes along the curve, slipping segments are halved until the chord hides nothing that
//! matters at the amplitude at hand.

use super::{
    AT_APEX, Increment, Matrix, NEGLIGIBLE, ON_CONE, Outcome, Vector, cut, dissipation_of_dead,
    forget_least,
};
use crate::backbone::{Backbone, Over, Values};
use crate::state::{Contact, Knot, Knots, MAX_KNOTS};
use arrayvec::ArrayVec;

type V = Vector<2>;
type M = Matrix<2>;

/// |v|^2 over R^2 that is outside the cone beyond doubt.
const OUTSIDE: f64 = 1.0 + 2e-12;
/// |v|^2 over R^2 that is at the limit: such an element slips when it was there before and is pushed outwards. One that
/// merely comes back to its limit sticks; otherwise a pulsing pressure wears the traction off.
const AT_LIMIT: f64 = 1.0 - 2e-14;
/// Knots closer than this part of R are one.
const SAME: f64 = 1e-12;
/// A segment shorter than this part of G has the mean of its ends' f' for a secant: the quotient is rounding.
const SHORT: f64 = 1e-8;
/// Over less than this part of G, where the backbone is nearly straight, differences of its integrals are rounding;
const NARROW: f64 = 1e-4;
/// over less than this they are whatever the backbone is.
const NO_ROOM: f64 = 1e-12;
/// How often a segment may be halved.
const HALVINGS: usize = 9;
/// Room for the trial curve: an apex, an old apex, and a full state.
const TRIAL: usize = MAX_KNOTS + 2;
/// Room for what one increment makes of it: fronts in every segment, and middles.
const PLACES: usize = 5 * MAX_KNOTS;
/// Beyond this angle (log-time) a direction has long come to its end; the exponential is still a number.
const FARTHEST: f64 = 300.0;
/// Importance of what must not go.
const KEEP: f64 = 1e300;
/// Importance of what need not stay.
const DROP: f64 = -1.0;

/// a x b.
#[inline(always)]
fn cross(a: &V, b: &V) -> f64 {
    a.x * b.y - a.y * b.x
}

/// A quarter turn to the left.
#[inline(always)]
fn left(a: &V) -> V {
    V::new(-a.y, a.x)
}

/// A direction and 1 over the length; `e` and 0 for no vector.
#[inline(always)]
fn direction(v: &V, e: &V) -> (V, f64) {
    // Never by 0, also where this is computed for nothing: hosts trap that.
    let squared = v.norm_squared();
    let inverse = 1.0 / squared.max(f64::MIN_POSITIVE).sqrt();
    if squared > 0.0 {
        (v * inverse, inverse)
    } else {
        (*e, 0.0)
    }
}

/// part / whole between 0 and 1 for whole >= 0; 1 for 0 / 0.
#[inline(always)]
fn share(part: f64, whole: f64) -> f64 {
    let inside = part.max(0.0)
        / if part < whole && whole > 0.0 {
            whole
        } else {
            1.0
        };
    if part >= whole { 1.0 } else { inside }
}

/// 1 / h, or 0.
#[inline(always)]
fn inverse_or_zero(h: f64) -> f64 {
    1.0 / if h > 0.0 { h } else { f64::INFINITY }
}

/// Whether |u| is at the limit R.
#[inline(always)]
fn on_cone(r: f64, u: &V) -> bool {
    u.norm_squared() >= r * r * (1.0 - 2.0 * ON_CONE)
}

/// Moves the curve `start` by an increment; `end`, empty before, gets the curve at the end.
// Not inlined: one copy per backbone, not one per face.
#[inline(never)]
pub fn step<B: Backbone>(
    backbone: &B,
    start: &mut Knots<2>,
    increment: &Increment<2>,
    end: &mut Knots<2>,
    outcome: &mut Outcome<2>,
) {
    let path = Path::new(increment);
    let curve = backbone.over(increment.critical);
    let initial_slope = curve.initial_slope();

    // 0. A new branch with no room for it: the least important knot goes before the step, so that one step and many agree.
    if start.len() == increment.room {
        let (r, u) = (start[0].r, V::from(start[0].u));
        if u.dot(&path.d) < 0.0 && on_cone(r, &u) {
            outcome.forgotten = forget_least(&backbone.over(increment.before), start, 0);
        }
    }

    // 1. Trial: every element moves by d, every limit by the growth De. 2. What is outside the cone slips.
    let mut trial = ArrayVec::<Trial, TRIAL>::new();
    let dead = path.trial(backbone, start, increment, &mut trial);
    let last = trial.len() - 1;
    let gross = trial[last].slips;

    // 3. The outermost place that slips sets the scale for what may be hidden by a chord.
    let slipping = trial.iter().rposition(|knot| knot.slips);
    let mut outermost = None;
    let mut tolerance = 0.0;
    outcome.contact = Contact::Stick;
    if let Some(index) = slipping {
        let (top, at) = if gross {
            (increment.critical, curve.end())
        } else {
            let segment = Segment::new(&trial[index], &trial[index + 1]);
            let front = path.front(&curve, &segment, segment.slip_ends());
            let scale = (front.r, front.at);
            outermost = Some(front);
            scale
        };
        if top > 0.0 {
            tolerance = (0.5 * increment.resolution * at.loss / top.max(f64::MIN_POSITIVE))
                .max(0.5 * increment.forgotten);
            outcome.contact = Contact::of(gross, at.slope, initial_slope);
        }
    }

    // 4. and 5. From the apex outwards: fronts, the return onto the cone, middles where the direction turns.
    let mut walk = Walk::new(&path, &curve, tolerance, trial.len(), outcome);
    let mut pair = [path.apex(initial_slope, &trial), Place::default()];
    walk.shared = pair[0].slip * pair[0].share * initial_slope;
    let [below, here] = &mut pair;
    let (mut below, mut here) = (below, here);
    for (index, knots) in trial.windows(2).enumerate() {
        let [a, b] = knots else { unreachable!() };
        path.place(&curve, b, index + 1 == last, here);
        if a.slips && b.slips {
            let both = below.was && here.was;
            if !both && let Some([ends, begins]) = Segment::new(a, b).pocket() {
                let segment = Segment::new(a, b);
                let front = path.front(&curve, &segment, ends);
                walk.go(below, &front, HALVINGS);
                let back = path.front(&curve, &segment, begins);
                walk.add(&front, &back);
                walk.go(&back, here, HALVINGS);
            } else {
                walk.go(below, here, HALVINGS);
            }
        } else if a.slips {
            let front = match &outermost {
                Some(front) if slipping == Some(index) => front,
                _ => {
                    let segment = Segment::new(a, b);
                    &path.front(&curve, &segment, segment.slip_ends())
                }
            };
            walk.go(below, front, HALVINGS);
            walk.add(front, here);
        } else if b.slips {
            let segment = Segment::new(a, b);
            let front = path.front(&curve, &segment, segment.slip_begins());
            walk.add(below, &front);
            walk.go(&front, here, HALVINGS);
        } else {
            walk.add(below, here);
        }
        std::mem::swap(&mut below, &mut here);
    }
    walk.finish(below, gross, dead);

    // 6. Forget what does not matter, and the least important when there are too many.
    walk.forget(increment.room, end);
}

/// A knot of the trial curve.
struct Trial {
    r: f64,
    v: V,
    /// Outside its limit.
    slips: bool,
    /// On the cone before the step.
    was: bool,
}

/// What a place on the curve does in the increment.
#[derive(Clone, Copy, Default, PartialEq)]
enum Kind {
    #[default]
    Stick,
    Slip,
    /// Slipping ends or begins here.
    Front,
}

/// A knot of the trial curve, a front or a middle, and where it goes.
#[derive(Default)]
struct Place {
    r: f64,
    /// Trial deflection, and deflection at the end.
    v: V,
    u: V,
    /// Direction of u where it slips.
    n: V,
    at: Values,
    /// How far it slips, e, and the share of the step in which it does, theta: its work is R e - De/2 e theta.
    slip: f64,
    share: f64,
    turn: Turn,
    kind: Kind,
    was: bool,
    /// How its place changes with the increment; None for an old knot, whose depth x = G - R is fixed.
    moves: Option<Moves>,
}

/// R d phi, phi the direction of u, for a slipping element: rows over the slip d and its start u0, numbers for G and the
/// depth x. The last two only for places that move.
#[derive(Default)]
struct Turn {
    by_slip: V,
    by_growth: f64,
    by_start: V,
    by_depth: f64,
}

/// How depth x = G - R and trial v of a place change with slip (row, matrix) and growth.
#[derive(Clone)]
struct Moves {
    depth_by_slip: V,
    depth_by_growth: f64,
    trial_by_slip: M,
    trial_by_growth: V,
}

impl Moves {
    /// Those of an old knot.
    const FIXED: Self = Moves {
        depth_by_slip: V::new(0.0, 0.0),
        depth_by_growth: 0.0,
        trial_by_slip: M::new(1.0, 0.0, 0.0, 1.0),
        trial_by_growth: V::new(0.0, 0.0),
    };

    fn between(a: &Option<Moves>, b: &Option<Moves>) -> Option<Moves> {
        if a.is_none() && b.is_none() {
            return None;
        }
        let (a, b) = (
            a.as_ref().unwrap_or(&Moves::FIXED),
            b.as_ref().unwrap_or(&Moves::FIXED),
        );
        Some(Moves {
            depth_by_slip: (a.depth_by_slip + b.depth_by_slip) * 0.5,
            depth_by_growth: (a.depth_by_growth + b.depth_by_growth) * 0.5,
            trial_by_slip: (a.trial_by_slip + b.trial_by_slip) * 0.5,
            trial_by_growth: (a.trial_by_growth + b.trial_by_growth) * 0.5,
        })
    }
}

/// A segment of the trial curve, and where it crosses the cone: the roots t of |v + t rise| = R + t width.
struct Segment {
    r: f64,
    v: V,
    width: f64,
    rise: V,
    /// a t^2 + 2 b t + c = 0.
    a: f64,
    b: f64,
    c: f64,
}

impl Segment {
    #[inline(always)]
    fn new(below: &Trial, above: &Trial) -> Self {
        let (r, v, width, rise) = (below.r, below.v, above.r - below.r, above.v - below.v);
        Segment {
            r,
            v,
            width,
            rise,
            a: rise.norm_squared() - width * width,
            b: v.dot(&rise) - r * width,
            c: v.norm_squared() - r * r,
        }
    }

    fn root(&self) -> f64 {
        (self.b * self.b - self.a * self.c).max(0.0).sqrt()
    }

    /// Where a slip below ends.
    fn slip_ends(&self) -> f64 {
        let q = self.root();
        if self.b > 0.0 {
            share(self.b + q, -self.a)
        } else {
            share(self.c, q - self.b)
        }
    }

    /// Where a slip above begins.
    fn slip_begins(&self) -> f64 {
        let q = self.root();
        if self.b < 0.0 {
            share(q - self.b, self.a)
        } else {
            share(-self.c, self.b + q)
        }
    }

    /// Both, where elements between two slipping ends stay inside their limits.
    #[inline(always)]
    fn pocket(&self) -> Option<[f64; 2]> {
        let square = self.b * self.b - self.a * self.c;
        if self.a > 0.0 && self.b < 0.0 && -self.b < self.a && square > 0.0 {
            let q = square.sqrt();
            Some([share(self.c, q - self.b), share(q - self.b, self.a)])
        } else {
            None
        }
    }
}

/// The slip and growth of the increment, and the exact path of a slipping element under them.
struct Path {
    d: V,
    length: f64,
    /// d / |d|, any unit vector without slip; 1 / |d|, 0 without slip.
    e: V,
    inverse: f64,
    /// De.
    growth: f64,
    critical: f64,
}

impl Path {
    #[inline(always)]
    fn new(increment: &Increment<2>) -> Self {
        let (e, inverse) = direction(&increment.slip, &V::new(1.0, 0.0));
        Path {
            d: increment.slip,
            length: increment.slip.norm(),
            e,
            inverse,
            growth: increment.critical - increment.before,
            critical: increment.critical,
        }
    }

    /// The trial curve, from the apex on, and which of its knots slip (the cone is convex, so that the path does not
    /// matter); gives the dissipation of what dies.
    #[inline(always)]
    fn trial<B: Backbone>(
        &self,
        backbone: &B,
        start: &Knots<2>,
        increment: &Increment<2>,
        trial: &mut ArrayVec<Trial, TRIAL>,
    ) -> f64 {
        let (d, growth, critical) = (self.d, self.growth, self.critical);
        let mut apex = Trial {
            r: 0.0,
            v: d,
            slips: self.length > 0.0,
            was: true,
        };
        let (mut died, mut dead) = (0, 0.0);
        if growth > 0.0 {
            // The old apex: below it, the elements born on the way lie on a straight line.
            let birth = self.knot(growth, d, true);
            (apex.v, apex.slips) = (V::zeros(), birth.slips);
            trial.push(apex);
            trial.push(birth);
        } else {
            if growth < 0.0 {
                let of_cut = cut(start, -growth);
                let curve = backbone.over(increment.before);
                dead =
                    increment.limit_ratio * dissipation_of_dead(&curve, start, of_cut, -growth, &d);
                died = of_cut.0;
                // It lies on the cone when the ends of its chord do.
                let on_cone = |knot: &Knot<2>| on_cone(knot.r, &knot.u.into());
                apex.was = on_cone(&start[died]) && (died == 0 || on_cone(&start[died - 1]));
                apex.v += of_cut.1;
                apex.slips = apex.v.norm_squared() > 0.0;
            }
            trial.push(apex);
        }
        let mut below = growth.max(0.0);
        for (index, knot) in start.iter().enumerate().skip(died) {
            // The end of the curve is exact; knots that a large growth brings together are one.
            let r = if index + 1 == start.len() {
                critical
            } else {
                (knot.r + growth).min(critical)
            };
            if r > below {
                let u = V::from(knot.u);
                let knot = self.knot(r, u + d, on_cone(knot.r, &u));
                trial.push(knot);
                below = r;
            }
        }
        dead
    }

    #[inline(always)]
    fn knot(&self, r: f64, mut v: V, was: bool) -> Trial {
        let (squared, limit) = (v.norm_squared(), r * r);
        let mut slips = squared >= limit * AT_LIMIT;
        if slips && squared <= limit * OUTSIDE {
            slips = was && v.dot(&self.d) > squared.sqrt() * self.growth;
            if !slips && squared > limit {
                v *= r / squared.max(f64::MIN_POSITIVE).sqrt();
            }
        }
        Trial { r, v, slips, was }
    }

    /// A knot of the trial curve, brought onto the cone if it slips.
    #[inline(always)]
    fn place<B: Backbone>(&self, curve: &Over<'_, B>, knot: &Trial, last: bool, place: &mut Place) {
        (place.r, place.v, place.u) = (knot.r, knot.v, knot.v);
        place.at = if last { curve.end() } else { curve.at(knot.r) };
        place.was = knot.was && knot.slips;
        place.moves = None;
        if knot.slips {
            place.kind = Kind::Slip;
            self.onto_cone(place);
        } else {
            place.kind = Kind::Stick;
            place.n = V::zeros();
            (place.slip, place.share) = (0.0, 0.0);
        }
    }

    /// The apex of the trial curve.
    fn apex(&self, initial_slope: f64, trial: &[Trial]) -> Place {
        let [knot, first, ..] = trial else {
            unreachable!()
        };
        let mut apex = Place {
            v: knot.v,
            n: self.e,
            was: knot.was,
            ..Place::default()
        };
        apex.at.slope = initial_slope;
        if knot.slips {
            apex.kind = Kind::Slip;
            if self.growth < 0.0 {
                // The limit of what is left there is as good as 0.
                apex.r = -1e-13 * self.growth;
                self.onto_cone(&mut apex);
                (apex.r, apex.u) = (0.0, V::zeros());
            } else if self.growth == 0.0 {
                apex.slip = self.length;
            }
        }
        let mut moves = Moves {
            depth_by_growth: 1.0,
            ..Moves::FIXED
        };
        if self.growth <= 0.0 {
            moves.trial_by_growth = (knot.v - first.v) / first.r;
        }
        apex.moves = Some(moves);
        apex
    }

    /// The place at `part` of a segment where slipping ends or begins.
    fn front<B: Backbone>(&self, curve: &Over<'_, B>, segment: &Segment, part: f64) -> Place {
        let r = (segment.r + part * segment.width).min(segment.r + segment.width);
        let v = segment.v + segment.rise * part;
        let (n, _) = direction(&v, &self.e);
        // It moves along the curve: n.dv - dR = 0 there, with the slope m of the trial curve.
        let m = segment.rise / segment.width;
        let speed = 1.0 - n.dot(&m);
        let over_speed = 1.0
            / if speed.abs() < 1e-9 {
                1e-9f64.copysign(speed)
            } else {
                speed
            };
        let depth_by_slip = -n * over_speed;
        Place {
            r,
            v,
            u: n * r,
            n,
            at: curve.at(r),
            kind: Kind::Front,
            moves: Some(Moves {
                depth_by_slip,
                depth_by_growth: over_speed,
                trial_by_slip: M::identity() - m * depth_by_slip.transpose(),
                trial_by_growth: -m * over_speed,
            }),
            ..Place::default()
        }
    }

    /// Half-way between two slipping places: the element half-way between them before the step.
    fn middle<B: Backbone>(&self, curve: &Over<'_, B>, a: &Place, b: &Place) -> Option<Place> {
        let (r, v) = (a.r + 0.5 * (b.r - a.r), (a.v + b.v) * 0.5);
        let was = a.was && b.was;
        let squared = v.norm_squared();
        // The chord of two knots on the cone dips inside it; the elements between them did not.
        let lifted = was && a.kind == Kind::Slip && b.kind == Kind::Slip;
        if squared == 0.0 || !(lifted || squared >= r * r * (1.0 - 2e-12)) {
            return None;
        }
        let mut place = Place {
            r,
            v,
            at: curve.at(r),
            kind: Kind::Slip,
            was,
            moves: Moves::between(&a.moves, &b.moves),
            ..Place::default()
        };
        self.onto_cone(&mut place);
        Some(place)
    }

    /// Brings a slipping element onto its limit along the exact path: it goes straight with d while its limit grows by De,
    /// touches the cone when the share s of the step is done, in direction h, and turns on it from there towards d.
    ///
    /// On the cone u = R n, u' = d - lambda n, lambda = n.d - De. With psi the angle from d to n, c and w its cosine and
    /// sine at h, and the log-time a = |d| int ds/R: d psi/da = - sin psi, so that [`Angle`] has the end.
    #[inline(always)]
    fn onto_cone(&self, place: &mut Place) {
        let Path {
            d,
            length,
            e,
            growth,
            ..
        } = *self;
        let r = place.r;
        let before = r - growth;
        let e_left = left(&e);
        if before <= 0.0 {
            // Born in this step: it slips along d from the start.
            (place.u, place.n) = (e * r, e);
            place.turn = Turn {
                by_slip: e_left * (r * self.inverse),
                ..Turn::default()
            };
            (place.slip, place.share) = ((length - growth).max(0.0), 1.0);
            return;
        }
        // Where it starts, and when it comes to its limit. `inverse`: 1 / |u0 + s d|, 0 where that is no direction.
        let start = place.v - d;
        let (n0, over_start) = direction(&start, &e);
        let (mut s, mut h, mut inverse) = (0.0, n0, over_start);
        if place.was {
            let outwards = n0.dot(&d) - growth;
            if outwards < 0.0 {
                s = share(-2.0 * before * outwards, length * length - growth * growth);
                (h, inverse) = direction(&(n0 * before + d * s), &e);
            }
        } else {
            let a = length * length - growth * growth;
            let b = start.dot(&d) - before * growth;
            let c = (start.norm_squared() - before * before).min(0.0);
            let q = (b * b - a * c).max(0.0).sqrt();
            s = if b < 0.0 {
                share(q - b, a)
            } else {
                share(-c, b + q)
            };
            (h, inverse) = direction(&(start + d * s), &e);
        }
        let r_h = before + s * growth;
        let slipping = 1.0 - s;
        let over_h = 1.0 / r_h;
        // al = int ds/R and int s ds/R^2 over the slip.
        let (mut al, mut moment) = (
            slipping * over_h,
            0.5 * slipping * (1.0 + s) * over_h * over_h,
        );
        if growth != 0.0 {
            let over_r = 1.0 / r;
            let twice_mean = 2.0 / (r + r_h);
            let y = 0.5 * growth * slipping * twice_mean;
            let yy = y * y;
            // atanh(y)/y, and what is left of the moment.
            let (q, j) = if yy < 0.01 {
                (
                    polynomial(yy, [1., 1. / 3., 1. / 5., 1. / 7., 1. / 9., 1. / 11.]),
                    -y * polynomial(yy, [4. / 3., 8. / 5., 12. / 7., 16. / 9., 20. / 11.]),
                )
            } else {
                let q = 0.5 * (r * over_h).ln() / y;
                (
                    q,
                    2.0 / y * (q - over_r * over_h / (twice_mean * twice_mean)),
                )
            };
            al = slipping * twice_mean * q;
            moment = 0.5 * slipping * (1.0 + s) * over_h * over_r
                + 0.25 * slipping * slipping * twice_mean * twice_mean * j;
        }
        let (a, c, w) = (length * al, h.dot(&e), cross(&e, &h));
        let Angle {
            cosine,
            sine,
            over_n,
            rise,
            log,
        } = if a < 1.0 {
            Angle::near(a, al, c, w)
        } else {
            Angle::far(a, self.inverse, c, w)
        };
        place.n = e * cosine + e_left * sine;
        place.u = place.n * r;
        place.turn.by_slip =
            e_left * (r * (rise + c * s * inverse * over_n)) - e * (r * sine * (s * inverse + al));
        place.turn.by_growth = r * sine * length * moment;
        if place.moves.is_some() {
            let turning = r * over_n * if s > 0.0 { inverse } else { over_h };
            place.turn.by_depth = -sine * length * slipping * over_h;
            if place.was {
                place.turn.by_start = left(&n0) * (turning * before * over_start * h.dot(&n0));
                place.turn.by_depth -= turning * cross(&h, &n0);
            } else {
                place.turn.by_start = left(&h) * turning;
            }
        }
        (place.slip, place.share) = ((r * log).max(0.0), 0.0);
        if growth != 0.0 {
            // Exact on straight lines, to first order otherwise.
            let (bend, fit) = (cosine - c, 2.0 + 1.2 * c);
            let slip = slipping * inverse_or_zero(al) * log;
            let slip = slip + growth * slipping * (a * bend / (12.0 + fit * a) - 1.0);
            place.slip = slip.max(0.0);
            let weight = 12.0 + fit * length * slipping * over_h;
            let part = 2.0 * slipping * slipping * length * bend / weight * inverse_or_zero(slip);
            if slip > 0.0 {
                place.share = (slipping - part).clamp(0.0, 2.0 * slipping);
            }
        }
    }
}

/// c_0 + c_1 x + ..
#[inline(always)]
fn polynomial<const N: usize>(x: f64, c: [f64; N]) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Where an element that turns on the cone comes to in log-time a, from an angle to d with cosine c and sine w. With
/// N = cosh a + c sinh a: cos psi = (sinh a + c cosh a)/N, sin psi = w/N.
struct Angle {
    cosine: f64,
    sine: f64,
    /// 1 / N.
    over_n: f64,
    /// (1 - 1/N) / |d|.
    rise: f64,
    /// ln N.
    log: f64,
}

impl Angle {
    /// By t = tanh(a/2) = p/q: N = (q^2 + 2 c p q + p^2)/(q^2 - p^2). a = |d| al.
    #[inline(always)]
    fn near(a: f64, al: f64, c: f64, w: f64) -> Self {
        // The continued fraction of tanh; below a = 1 nothing is left out.
        let x = 0.25 * a * a;
        let p1 = polynomial(x, [1., 17_325. / 135_135., 378. / 135_135., 1. / 135_135.]);
        let q = polynomial(
            x,
            [1., 62_370. / 135_135., 3_150. / 135_135., 28. / 135_135.],
        );
        let p = 0.5 * a * p1;
        let (pp, qq, pq) = (p * p, q * q, 2.0 * p * q);
        let (ahead, whole, half) = (p + c * q, qq + c * pq + pp, q * (q + c * p));
        let over = 1.0 / (whole * half);
        let (over_whole, over_half) = (half * over, whole * over);
        // ln N = 2 atanh(y)
        let y = p * ahead * over_half;
        let yy = y * y;
        let log = if yy < 0.01 {
            y * polynomial(
                yy,
                [2., 2. / 3., 2. / 5., 2. / 7., 2. / 9., 2. / 11., 2. / 13.],
            )
        } else {
            ((1.0 + y) / (1.0 - y)).ln()
        };
        let over_n = (qq - pp) * over_whole;
        Angle {
            cosine: (c * (qq + pp) + pq) * over_whole,
            sine: w * over_n,
            over_n,
            rise: al * p1 * ahead * over_whole,
            log,
        }
    }

    /// By exponentials. `inverse`: 1 / |d|.
    #[inline(never)]
    fn far(a: f64, inverse: f64, c: f64, w: f64) -> Self {
        let exponential = a.min(FARTHEST).exp();
        // 1 + c without cancellation.
        let plus = exponential * if c < 0.0 { w * w / (1.0 - c) } else { 1.0 + c };
        let minus = (1.0 - c) / exponential;
        let over_n = 2.0 / (plus + minus);
        Angle {
            cosine: 0.5 * (plus - minus) * over_n,
            sine: w * over_n,
            over_n,
            rise: (1.0 - over_n) * inverse,
            log: (0.5 * (plus + minus)).ln() + (a - FARTHEST).max(0.0),
        }
    }
}

/// A place of the curve at the end.
struct Kept {
    r: f64,
    u: V,
    n: V,
    f: f64,
    kind: Kind,
    /// Numbers of the places beside it that are left.
    below: u16,
    above: u16,
}

/// Goes along the curve at the end from the apex outwards, and adds up what it gives.
struct Walk<'a, B> {
    path: &'a Path,
    curve: &'a Over<'a, B>,
    /// Square of the part of T that a chord may hide.
    tolerance: f64,
    /// How many places may be added as middles before the room for the rest is touched.
    middles: usize,
    /// Square of the largest part of T that a chord hides for want of room.
    hidden: f64,
    kept: ArrayVec<Kept, PLACES>,
    /// Squares of the part of T that is lost with each of them; infinite for the apex and for what was dropped.
    importance: ArrayVec<f64, PLACES>,
    needless: bool,
    /// The segment last added: width, secant of f, slope of u.
    width: f64,
    secant: f64,
    slope: V,
    /// sum (e_a - e_b)/h (L_b - L_a), and int e theta k dR.
    work: f64,
    shared: f64,
    /// The part of the tangent that is a multiple of the identity.
    sticking: f64,
    /// Takes the other sums.
    outcome: &'a mut Outcome<2>,
}

impl<'a, B: Backbone> Walk<'a, B> {
    #[inline(always)]
    fn new(
        path: &'a Path,
        curve: &'a Over<'a, B>,
        tolerance: f64,
        trial: usize,
        outcome: &'a mut Outcome<2>,
    ) -> Self {
        Walk {
            path,
            curve,
            tolerance: tolerance * tolerance,
            // Two fronts and a knot per segment must fit.
            middles: PLACES - 3 * trial,
            hidden: 0.0,
            kept: ArrayVec::new(),
            importance: ArrayVec::new(),
            needless: false,
            width: 0.0,
            secant: 0.0,
            slope: V::zeros(),
            work: 0.0,
            shared: 0.0,
            sticking: 0.0,
            outcome,
        }
    }

    /// From place a, the last one added, to b, with middles where the direction turns: a chord hides h/4 |n_b - n_a| |kink|,
    /// h = R_b - R_a, kink = change of f' half-way.
    fn go(&mut self, a: &Place, b: &Place, halvings: usize) {
        let half = 0.5 * (b.r - a.r);
        let kink = half * (a.at.slope - b.at.slope);
        let hidden = 0.0625 * (b.n - a.n).norm_squared() * kink * kink;
        let born = self.kept.is_empty() && self.path.growth > 0.0;
        if hidden > self.tolerance && half > SAME * self.path.critical && !born {
            if halvings == 0 || self.middles == 0 {
                self.hidden = self.hidden.max(hidden);
            } else if let Some(middle) = self.path.middle(self.curve, a, b) {
                self.middles -= 1;
                self.go(a, &middle, halvings - 1);
                self.go(&middle, b, halvings - 1);
                return;
            }
        }
        self.add(a, b);
    }

    /// Adds the segment from place a, the last one added, to b: Eqs. (1) and (2).
    #[inline(always)]
    fn add(&mut self, a: &Place, b: &Place) {
        let width = b.r - a.r;
        let (mut secant, mut slope) = (b.at.slope, V::zeros());
        if width > 0.0 {
            let inverse = 1.0 / width;
            let df = b.at.f - a.at.f;
            let f = 0.5 * (a.at.f + b.at.f);
            let mut loss = b.at.loss - a.at.loss;
            // What F has more than by a straight f.
            let mut bulge = b.at.integral - a.at.integral - f * width;
            let critical = self.path.critical;
            let kink = a.at.slope - b.at.slope;
            if width <= NO_ROOM * critical
                || (width <= NARROW * critical && kink <= 1e-4 * a.at.slope)
            {
                // By L' = f - R f' in the middle, and the third derivative of F.
                loss = (f - 0.5 * (a.r * a.at.slope + b.r * b.at.slope)) * width;
                bulge = kink * width * width * (1.0 / 12.0);
            }
            secant = if width > SHORT * critical {
                df * inverse
            } else {
                0.5 * (a.at.slope + b.at.slope)
            };
            slope = (b.u - a.u) * inverse;
            self.outcome.traction += slope * df;
            self.outcome.stored +=
                0.5 * slope.dot(&(a.u + b.u)) * df - slope.norm_squared() * bulge;
            if a.slip > 0.0 || b.slip > 0.0 {
                let fall = (a.slip - b.slip) * inverse;
                self.work += fall * loss;
                if self.path.growth != 0.0 {
                    let rise = (b.share - a.share) * inverse;
                    self.shared +=
                        secant * (b.slip * b.share - a.slip * a.share) + 2.0 * fall * rise * bulge;
                }
            }
        }
        let importance = match self.kept.last() {
            Some(below) => {
                let bend = self.slope - slope;
                importance(
                    (below.kind, &below.n),
                    (a.kind, a.r),
                    (b.kind, &b.n, b.r == self.path.critical),
                    self.width,
                    width,
                    &bend,
                    self.secant - secant,
                    (AT_APEX * self.path.critical, 0.25 * self.tolerance),
                )
            }
            None => f64::INFINITY,
        };
        self.needless |= importance < 0.0;
        self.settle(a, secant, &slope);
        self.keep(a, importance);
        (self.width, self.secant, self.slope) = (width, secant, slope);
    }

    #[inline(always)]
    fn keep(&mut self, place: &Place, importance: f64) {
        let number = self.kept.len() as u16;
        self.importance.push(importance);
        self.kept.push(Kept {
            r: place.r,
            u: place.u,
            n: place.n,
            f: place.at.f,
            kind: place.kind,
            below: number.wrapping_sub(1),
            above: number + 1,
        });
    }

    /// What a place gives to the tangents: the secant below it is known, above it is `secant`, and u has the slope `slope`.
    #[inline(always)]
    fn settle(&mut self, place: &Place, secant: f64, slope: &V) {
        let (n, turn) = (&place.n, &place.turn);
        let weight = self.secant - secant;
        match (&place.moves, place.kind) {
            (None, Kind::Stick) => self.sticking += weight,
            (None, _) => {
                // du = n dG + n_left R d phi
                let n_left = left(n);
                self.outcome.by_slip += n_left * weight * turn.by_slip.transpose();
                self.outcome.by_growth += (n + n_left * turn.by_growth) * weight;
            }
            (Some(moves), _) => self.settle_moving(place, moves, weight, secant, slope),
        }
    }

    /// The same for a place that moves along the curve.
    fn settle_moving(&mut self, place: &Place, moves: &Moves, weight: f64, secant: f64, slope: &V) {
        let (n, turn) = (place.n, &place.turn);
        let at_apex = self.kept.is_empty();
        let mut along = slope * (place.at.slope - secant);
        if at_apex {
            if self.path.growth <= 0.0 && place.kind == Kind::Stick {
                // Nothing slips: the elements below the first knot stick, too.
                self.sticking += place.at.slope - secant;
                if self.path.growth == 0.0 {
                    // Without any increment the apex does not move: the side of a rising limit.
                    return;
                }
            }
        } else {
            along += self.slope * (self.secant - place.at.slope);
            if place.kind == Kind::Front {
                self.outcome.by_slip += moves.trial_by_slip * weight;
                self.outcome.by_growth += moves.trial_by_growth * weight;
            } else {
                // du0 = dv - dd
                let start = moves.trial_by_slip - M::identity();
                let by_slip = turn.by_slip
                    + start.transpose() * turn.by_start
                    + moves.depth_by_slip * turn.by_depth;
                let by_growth = turn.by_growth
                    + turn.by_start.dot(&moves.trial_by_growth)
                    + turn.by_depth * moves.depth_by_growth;
                let n_left = left(&n);
                self.outcome.by_slip +=
                    (n_left * by_slip.transpose() - n * moves.depth_by_slip.transpose()) * weight;
                self.outcome.by_growth +=
                    (n * (1.0 - moves.depth_by_growth) + n_left * by_growth) * weight;
            }
        }
        self.outcome.by_slip += along * moves.depth_by_slip.transpose();
        self.outcome.by_growth += along * moves.depth_by_growth;
    }

    /// After the last place nothing holds any more: f' is 0 there. `dead`: the dissipation of what died.
    #[inline(always)]
    fn finish(&mut self, last: &Place, gross: bool, dead: f64) {
        self.settle(last, 0.0, &V::zeros());
        self.keep(last, KEEP);
        self.outcome.by_slip[(0, 0)] += self.sticking;
        self.outcome.by_slip[(1, 1)] += self.sticking;
        let end = if gross { last.slip } else { 0.0 };
        self.outcome.dissipated = self.work + end - 0.5 * self.path.growth * self.shared + dead;
    }

    /// Writes the knots that matter to `end`, at most `room`; tells the largest part of T that was given up.
    #[inline(always)]
    fn forget(&mut self, room: usize, end: &mut Knots<2>) {
        let last = self.kept.len() - 1;
        let mut count = last;
        if self.needless {
            let mut k = 1;
            while k < last {
                let Kept { below, above, .. } = self.kept[k];
                let needless = self.importance[k] < 0.0;
                if needless {
                    self.drop(k);
                    count -= 1;
                }
                k = usize::from(if needless && below > 0 { below } else { above });
            }
        }
        let mut given_up = self.hidden;
        while count > room {
            let (mut least, mut index) = (f64::INFINITY, 1);
            for (k, &importance) in self.importance[..last].iter().enumerate() {
                if importance < least {
                    (least, index) = (importance, k);
                }
            }
            if least < KEEP {
                given_up = given_up.max(least);
            }
            self.drop(index);
            count -= 1;
        }
        for (place, &importance) in self.kept.iter().zip(&self.importance) {
            if importance < f64::INFINITY {
                end.push(Knot {
                    r: place.r,
                    u: place.u.into(),
                });
            }
        }
        self.outcome.forgotten = self.outcome.forgotten.max(given_up.sqrt());
    }

    /// Drops place k, neither the first nor the last: its importance becomes infinite, those beside it are neighbours.
    fn drop(&mut self, k: usize) {
        let (below, above) = (self.kept[k].below, self.kept[k].above);
        self.importance[k] = f64::INFINITY;
        self.kept[below as usize].above = above;
        self.kept[above as usize].below = below;
        for k in [below as usize, above as usize] {
            if k > 0 && k + 1 < self.kept.len() {
                let b = &self.kept[k];
                let (a, c) = (&self.kept[b.below as usize], &self.kept[b.above as usize]);
                let (low, high) = (b.r - a.r, c.r - b.r);
                // Where one of them is 0 the place goes anyway.
                let [over_low, over_high] = [low, high].map(inverse_or_zero);
                let bend = (b.u - a.u) * over_low - (c.u - b.u) * over_high;
                let kink = (b.f - a.f) * over_low - (c.f - b.f) * over_high;
                self.importance[k] = importance(
                    (a.kind, &a.n),
                    (b.kind, b.r),
                    (c.kind, &c.n, c.r == self.path.critical),
                    low,
                    high,
                    &bend,
                    kink,
                    (AT_APEX * self.path.critical, 0.25 * self.tolerance),
                );
            }
        }
    }
}

/// Square of the part of T that is lost with a place b between a and c, `low` above a and `high` below c: the traction changes
/// by |off the chord| |kink|, and on the cone the chord would hide h/4 |n_c - n_a| |kink|. Fronts stay where they are not
/// doubled. `bend`: change of the slope of u at b, `kink`: of that of f; c also tells whether it is the end of the curve.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
fn importance(
    (kind_a, n_a): (Kind, &V),
    (kind, r): (Kind, f64),
    (kind_c, n_c, end): (Kind, &V, bool),
    low: f64,
    high: f64,
    bend: &V,
    kink: f64,
    (at_apex, tolerance): (f64, f64),
) -> f64 {
    let near = SAME * r;
    if kind == Kind::Front {
        let doubled = (low <= near && kind_a == Kind::Front)
            || (high <= near && (end || kind_c == Kind::Front));
        return if r <= at_apex || doubled { DROP } else { KEEP };
    }
    if low <= near || high <= near {
        return DROP;
    }
    let along = low * high / (low + high).max(f64::MIN_POSITIVE);
    let kinked = kink * kink;
    let mut importance = bend.norm_squared() * along * along * kinked;
    if importance < NEGLIGIBLE * NEGLIGIBLE {
        importance = DROP;
    }
    if kind == Kind::Slip && kind_a != Kind::Stick && kind_c != Kind::Stick {
        let hidden = 0.0625 * (low + high) * (low + high) * (n_c - n_a).norm_squared() * kinked;
        if importance > 0.0 || hidden > tolerance {
            return importance.max(hidden);
        }
    }
    importance
}
