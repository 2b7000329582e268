//! Two directions: a curve in a cone.
//!
//! Slipping elements turn: each one goes back onto the cone along the exact path of an element under a straight slip,
//! and where the direction changes along the curve, slipping segments are halved until the chord hides nothing that
//! matters at the amplitude at hand.

use super::{AT_APEX, Increment, Matrix, NEGLIGIBLE, ON_CONE, Outcome, Vector};
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
/// How often a segment may be halved.
const HALVINGS: usize = 9;
/// Room for what one increment makes of a full state: fronts in every segment, and middles.
const NODES: usize = 5 * MAX_KNOTS;
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

/// part / whole between 0 and 1 for whole >= 0, without a division that hosts could trap.
#[inline(always)]
fn share(part: f64, whole: f64) -> f64 {
    if part >= whole {
        1.0
    } else if part > 0.0 {
        part / whole
    } else {
        0.0
    }
}

/// What a place on the curve does in the increment.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Stick,
    Slip,
    /// Slipping ends or begins here.
    Front,
}

/// A knot of the trial curve, a front or a middle, and where it goes.
#[derive(Clone, Copy)]
struct Node {
    r: f64,
    /// Trial deflection.
    v: V,
    /// Deflection at the end.
    u: V,
    /// Direction of u where it slips.
    n: V,
    at: Values,
    /// How far it slips, e, and the share of the step in which it does, theta: its work is R e - De/2 e theta.
    slip: f64,
    share: f64,
    turn: Turn,
    kind: Kind,
    /// On the cone before the step.
    was: bool,
    /// How its place changes with the increment; None for an old knot, whose depth x = G - R is fixed.
    moves: Option<Moves>,
}

/// R d phi, phi the direction of u, for a slipping element: rows over the slip d and its start u0, numbers for G and the
/// depth x.
#[derive(Clone, Copy, Default)]
struct Turn {
    by_slip: V,
    by_growth: f64,
    by_start: V,
    by_depth: f64,
}

/// How depth x = G - R and trial v of a place change with slip (row, matrix) and growth.
#[derive(Clone, Copy)]
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

    fn between(a: Option<Moves>, b: Option<Moves>) -> Option<Moves> {
        if a.is_none() && b.is_none() {
            return None;
        }
        let (a, b) = (a.unwrap_or(Moves::FIXED), b.unwrap_or(Moves::FIXED));
        Some(Moves {
            depth_by_slip: (a.depth_by_slip + b.depth_by_slip) * 0.5,
            depth_by_growth: (a.depth_by_growth + b.depth_by_growth) * 0.5,
            trial_by_slip: (a.trial_by_slip + b.trial_by_slip) * 0.5,
            trial_by_growth: (a.trial_by_growth + b.trial_by_growth) * 0.5,
        })
    }
}

/// Moves the curve `start` by an increment; `end`, empty before, gets the curve at the end.
#[inline(always)]
pub fn step<B: Backbone>(
    backbone: &B,
    start: &mut Knots<2>,
    increment: &Increment<2>,
    end: &mut Knots<2>,
) -> Outcome<2> {
    let path = Path::new(increment);
    let curve = backbone.over(increment.critical);
    let mut forgotten = 0.0;

    // 0. A new branch with no room for it: the least important knot goes before the step, so that one step and many agree.
    if start.len() == increment.room && turns_back(&start[0], &path.d) {
        forgotten = forget_least(&backbone.over(increment.before), start);
    }

    // 1. Trial: every element moves by d, every limit by the growth De. 2. What is outside the cone slips.
    let mut trial = Trial::default();
    trial.fill(&path, start, increment);
    let dead = if path.growth < 0.0 {
        trial.dissipation_of_dead(&path, &backbone.over(increment.before), start) * increment.limit_ratio
    } else {
        0.0
    };
    trial.find_slipping(&path);

    // 3. The outermost place that slips sets the scale for what may be hidden by a chord.
    let gross = trial.slips.last().copied().unwrap_or(false);
    let top = if gross { increment.critical } else { trial.top };
    let scale = if top > 0.0 { curve.at(top) } else { Values::default() };
    let mut tolerance = 0.0;
    if top > 0.0 {
        tolerance = (0.5 * increment.resolution * scale.loss / top).max(0.5 * increment.forgotten);
    }

    // 4. and 5. From the apex outwards: fronts, the return onto the cone, middles where the direction turns.
    let mut nodes = ArrayVec::<Node, TRIAL>::new();
    for ((knot, &slips), &was) in trial.knots.iter().zip(&trial.slips).zip(&trial.was) {
        nodes.push(path.node(&curve, knot.r, knot.u.into(), slips, was && slips));
    }
    let mut kept = ArrayVec::new();
    let apex = path.apex(&curve, &trial);
    let mut walk = Walk::new(&path, &curve, &mut kept, tolerance, nodes.len(), apex);
    for index in 1..nodes.len() {
        let (below, slips) = (trial.slips[index - 1], trial.slips[index]);
        let segment = Segment::new(&trial.knots[index - 1], &trial.knots[index]);
        if below != slips {
            let part = if below { segment.slip_ends() } else { segment.slip_begins() };
            walk.refine(path.front(&curve, &segment, part));
        } else if slips && !(nodes[index].was && walk.last.was) && let Some([ends, begins]) = segment.pocket() {
            walk.refine(path.front(&curve, &segment, ends));
            walk.add(path.front(&curve, &segment, begins));
        }
        if slips {
            walk.refine(nodes[index]);
        } else {
            walk.add(nodes[index]);
        }
    }
    walk.finish();

    // 6. Forget what does not matter, and the least important when there are too many.
    forgotten = f64::max(forgotten, walk.hidden);
    forgotten = forgotten.max(walk.forget(increment.room, end));
    Outcome {
        traction: walk.traction,
        by_slip: walk.by_slip + M::identity() * walk.sticking,
        by_growth: walk.by_growth,
        stored: walk.stored,
        dissipated: walk.dissipated(gross) + dead,
        contact: if top > 0.0 {
            Contact::of(gross, scale.slope, curve.initial_slope())
        } else {
            Contact::Stick
        },
        forgotten,
    }
}

/// Whether |u| is at the limit R.
#[inline(always)]
fn on_cone(knot: &Knot<2>) -> bool {
    let u = V::from(knot.u);
    u.norm_squared() >= knot.r * knot.r * (1.0 - 2.0 * ON_CONE)
}

fn turns_back(first: &Knot<2>, d: &V) -> bool {
    V::from(first.u).dot(d) < 0.0 && on_cone(first)
}

/// The smallest limit, over that at the start, whose reciprocal is taken.
const NEAR_APEX: f64 = 1e-30;

/// The slip and growth of the increment, and the exact path of a slipping element under them.
struct Path {
    d: V,
    length: f64,
    /// 1 / |d|, 0 without slip.
    inverse: f64,
    /// d / |d|; any unit vector without slip.
    e: V,
    /// De.
    growth: f64,
    critical: f64,
}

impl Path {
    #[inline(always)]
    fn new(increment: &Increment<2>) -> Self {
        let d = increment.slip;
        let length = d.norm();
        // Not by zero in either case: compilers divide first, and some hosts trap that.
        let whole = length + f64::from(u8::from(length == 0.0));
        let (over, along) = (1.0 / whole, d / whole);
        let (inverse, e) = if length > 0.0 {
            (over, along)
        } else {
            (0.0, V::new(1.0, 0.0))
        };
        Path {
            d,
            length,
            inverse,
            e,
            growth: increment.critical - increment.before,
            critical: increment.critical,
        }
    }

    /// The apex of the trial curve.
    #[inline(always)]
    fn apex<B: Backbone>(&self, curve: &Over<'_, B>, trial: &Trial) -> Node {
        let slips = trial.slips[0];
        let v = V::from(trial.knots[0].u);
        let mut node = self.node(curve, 0.0, v, false, trial.was[0]);
        node.u = V::zeros();
        node.n = self.e;
        if slips && self.growth < 0.0 {
            // The limit of what is left there is as good as 0.
            node.r = -1e-13 * self.growth;
            node.kind = Kind::Slip;
            self.onto_cone(&mut node);
            (node.r, node.u) = (0.0, V::zeros());
        } else if slips && self.growth == 0.0 {
            node.slip = self.length;
        }
        node.kind = if slips { Kind::Slip } else { Kind::Stick };
        let mut moves = Moves {
            depth_by_growth: 1.0,
            ..Moves::FIXED
        };
        if self.growth <= 0.0 {
            let first = &trial.knots[1];
            moves.trial_by_growth = (v - V::from(first.u)) / first.r;
        }
        node.moves = Some(moves);
        node
    }

    /// A knot of the trial curve, brought onto the cone if it slips.
    #[inline(always)]
    fn node<B: Backbone>(&self, curve: &Over<'_, B>, r: f64, v: V, slips: bool, was: bool) -> Node {
        let mut node = Node {
            r,
            v,
            u: v,
            n: V::zeros(),
            at: curve.at(r),
            slip: 0.0,
            share: 0.0,
            turn: Turn::default(),
            kind: Kind::Stick,
            was,
            moves: None,
        };
        if slips {
            node.kind = Kind::Slip;
            self.onto_cone(&mut node);
        }
        node
    }

    /// The place at `part` of a segment where slipping ends or begins.
    fn front<B: Backbone>(&self, curve: &Over<'_, B>, segment: &Segment, part: f64) -> Node {
        let r = (segment.r + part * segment.width).min(segment.r + segment.width);
        let v = segment.v + segment.rise * part;
        let length = v.norm();
        let whole = length + f64::from(u8::from(length == 0.0));
        let along = v / whole;
        let n = if length > 0.0 { along } else { self.e };
        // It moves along the curve: n.dv - dR = 0 there, with the slope m of the trial curve.
        let m = segment.rise / segment.width;
        let speed = 1.0 - n.dot(&m);
        let speed = if speed.abs() < 1e-9 { 1e-9f64.copysign(speed) } else { speed };
        let (depth_by_slip, depth_by_growth) = (-n / speed, 1.0 / speed);
        let mut node = self.node(curve, r, v, false, false);
        node.u = n * r;
        node.n = n;
        node.kind = Kind::Front;
        node.moves = Some(Moves {
            depth_by_slip,
            depth_by_growth,
            trial_by_slip: M::identity() - m * depth_by_slip.transpose(),
            trial_by_growth: -m * depth_by_growth,
        });
        node
    }

    /// Half-way between two slipping places: the element half-way between them before the step.
    #[inline(always)]
    fn middle<B: Backbone>(&self, curve: &Over<'_, B>, a: &Node, b: &Node) -> Option<Node> {
        let (r, v) = (a.r + 0.5 * (b.r - a.r), (a.v + b.v) * 0.5);
        let was = a.was && b.was;
        let squared = v.norm_squared();
        // The chord of two knots on the cone dips inside it; the elements between them did not.
        let lifted = was && a.kind == Kind::Slip && b.kind == Kind::Slip;
        if squared == 0.0 || !(lifted || squared >= r * r * (1.0 - 2e-12)) {
            return None;
        }
        let mut node = self.node(curve, r, v, false, was);
        node.moves = Moves::between(a.moves, b.moves);
        node.kind = Kind::Slip;
        self.onto_cone(&mut node);
        Some(node)
    }

    /// Brings a slipping element onto its limit along the exact path: it goes straight with d while its limit grows by De,
    /// touches the cone when the share s of the step is done, in direction h, and turns on it from there towards d.
    ///
    /// On the cone u = R n, u' = d - lambda n, lambda = n.d - De. With psi the angle from d to n and the log-time
    /// a = |d| int ds/R: d psi/da = - sin psi, so that cos psi = (sinh a + c cosh a)/N, sin psi = w/N,
    /// N = cosh a + c sinh a, where c, w are cosine and sine of psi at h.
    #[inline(always)]
    fn onto_cone(&self, node: &mut Node) {
        let Path { d, length, e, growth, .. } = *self;
        let r = node.r;
        let before = r - growth;
        let e_left = left(&e);
        if before <= 0.0 {
            // Born in this step: it slips along d from the start.
            (node.u, node.n) = (e * r, e);
            node.turn = Turn {
                by_slip: e_left * (r * self.inverse),
                ..Turn::default()
            };
            (node.slip, node.share) = ((length - growth).max(0.0), 1.0);
            return;
        }
        // Where it starts, and when it comes to its limit.
        let start = node.v - d;
        let squared = start.norm_squared();
        let (mut s, mut h, mut r_h) = (0.0, e, before);
        // 1 / |u0 + s d|, 0 where that is no direction; direction and stretch of the start.
        let (mut inverse, mut n0, mut stretch) = (0.0, V::zeros(), 1.0);
        if node.was && squared > 0.0 {
            let over = 1.0 / squared.sqrt();
            n0 = start * over;
            (h, inverse, stretch) = (n0, over, before * over);
            let outwards = n0.dot(&d) - growth;
            if outwards < 0.0 {
                s = share(-2.0 * before * outwards, length * length - growth * growth);
                if s > 0.0 {
                    (h, inverse) = direction(&(n0 * before + d * s), &e);
                    r_h = before + s * growth;
                }
            }
        } else if !node.was {
            let a = length * length - growth * growth;
            let b = start.dot(&d) - before * growth;
            let c = (squared - before * before).min(0.0);
            let q = (b * b - a * c).max(0.0).sqrt();
            s = if b < 0.0 { share(q - b, a) } else { share(-c, b + q) };
            (h, inverse) = direction(&(start + d * s), &e);
            r_h = before + s * growth;
        }
        // An element that ends at the apex turns for ever; next to it, it is where it would be.
        let (r, r_h) = (r.max(NEAR_APEX * before), r_h.max(NEAR_APEX * before));
        let slipping = 1.0 - s;
        let over_h = 1.0 / r_h;
        // al = int ds/R and int s ds/R^2 over the slip.
        let (al, moment);
        if growth == 0.0 {
            al = slipping * over_h;
            moment = 0.5 * slipping * (1.0 + s) * over_h * over_h;
        } else {
            let over_r = 1.0 / r;
            let twice_mean = 2.0 / (r + r_h);
            let y = 0.5 * growth * slipping * twice_mean;
            let yy = y * y;
            // atanh(y)/y, and what is left of the moment.
            let (q, j) = if yy < 0.01 {
                (
                    1.0 + yy * (1. / 3. + yy * (1. / 5. + yy * (1. / 7. + yy * (1. / 9. + yy * (1. / 11.))))),
                    -y * (4. / 3. + yy * (8. / 5. + yy * (12. / 7. + yy * (16. / 9. + yy * (20. / 11.))))),
                )
            } else {
                let q = 0.5 * (r * over_h).ln() / y;
                (q, 2.0 / y * (q - over_r * over_h / (twice_mean * twice_mean)))
            };
            al = slipping * twice_mean * q;
            moment = 0.5 * slipping * (1.0 + s) * over_h * over_r
                + 0.25 * slipping * slipping * twice_mean * twice_mean * j;
        }
        let a = length * al;
        let (c, w) = (h.dot(&e), cross(&e, &h));
        // N, k = N cos psi, g = (N - 1)/|d|.
        let (big_n, k, g);
        if a < 0.5 {
            // sinh(a)/a and (cosh(a) - 1)/a.
            let aa = a * a;
            let sinh = 1.0
                + aa * (1. / 6. + aa * (1. / 120. + aa * (1. / 5040. + aa * (1. / 362_880. + aa * (1. / 39_916_800.)))));
            let cosh = a
                * (0.5
                    + aa * (1. / 24.
                        + aa * (1. / 720. + aa * (1. / 40_320. + aa * (1. / 3_628_800. + aa * (1. / 479_001_600.))))));
            big_n = 1.0 + a * (cosh + c * sinh);
            k = c + a * (sinh + c * cosh);
            g = al * (cosh + c * sinh);
        } else {
            let exponential = a.min(FARTHEST).exp();
            let plus = exponential * if c < 0.0 { w * w / (1.0 - c) } else { 1.0 + c };
            let minus = (1.0 - c) / exponential;
            big_n = 0.5 * (plus + minus);
            k = 0.5 * (plus - minus);
            g = (big_n - 1.0) * self.inverse;
        }
        let over_n = 1.0 / big_n;
        let (cosine, sine) = (k * over_n, w * over_n);
        node.n = e * cosine + e_left * sine;
        node.u = node.n * r;
        node.turn = Turn {
            by_slip: e_left * (r * over_n * (g + c * s * inverse)) - e * (r * sine * (s * inverse + al)),
            by_growth: r * sine * length * moment,
            ..Turn::default()
        };
        if node.moves.is_some() {
            let turning = r * over_n * if s > 0.0 { inverse } else { over_h };
            node.turn.by_depth = -sine * length * slipping * over_h;
            if node.was {
                node.turn.by_start = left(&n0) * (turning * stretch * h.dot(&n0));
                node.turn.by_depth -= turning * cross(&h, &n0);
            } else {
                node.turn.by_start = left(&h) * turning;
            }
        }
        // ln N.
        let more = length * g;
        let log = if a < 0.5 && more.abs() < 0.1 {
            let y = more / (2.0 + more);
            let yy = y * y;
            y * (2.0 + yy * (2. / 3. + yy * (2. / 5. + yy * (2. / 7. + yy * (2. / 9.)))))
        } else {
            big_n.ln() + (a - FARTHEST).max(0.0)
        };
        if growth == 0.0 {
            node.slip = (r * log).max(0.0);
        } else {
            // Exact without growth and on straight lines, to first order otherwise.
            let (bend, fit) = (cosine - c, 2.0 + 1.2 * c);
            let slip = if al > 0.0 { slipping / al * log } else { 0.0 };
            let slip = slip + growth * slipping * (a * bend / (12.0 + fit * a) - 1.0);
            node.slip = slip.max(0.0);
            if slip > 0.0 {
                let weight = (12.0 + fit * length * slipping * over_h) * slip;
                node.share = (slipping - 2.0 * slipping * slipping * length * bend / weight).max(0.0);
            }
        }
    }
}

/// A direction and 1 over the length; `e` and 0 for no vector.
#[inline(always)]
fn direction(v: &V, e: &V) -> (V, f64) {
    let squared = v.norm_squared();
    if squared > 0.0 {
        let inverse = 1.0 / squared.sqrt();
        (v * inverse, inverse)
    } else {
        (*e, 0.0)
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
    fn new(below: &Knot<2>, above: &Knot<2>) -> Self {
        let (v, width) = (V::from(below.u), above.r - below.r);
        let rise = V::from(above.u) - v;
        Segment {
            r: below.r,
            v,
            width,
            rise,
            a: rise.norm_squared() - width * width,
            b: v.dot(&rise) - below.r * width,
            c: v.norm_squared() - below.r * below.r,
        }
    }

    #[inline(always)]
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

/// Room for the apex, an old apex, and a full state.
const TRIAL: usize = MAX_KNOTS + 2;

/// The curve after the trial, from the apex on.
#[derive(Default)]
struct Trial {
    /// Slip limits and trial deflections.
    knots: ArrayVec<Knot<2>, TRIAL>,
    /// On the cone before the step.
    was: ArrayVec<bool, TRIAL>,
    slips: ArrayVec<bool, TRIAL>,
    /// R of the outermost place that slips, 0 where none does.
    top: f64,
    /// Old knots that died with a shrinking cone, and the old deflection where the apex is now.
    died: usize,
    cut: V,
}

impl Trial {
    // Filled in place: thousands of bytes that travel by value cost more than the update.
    #[inline(always)]
    fn fill(&mut self, path: &Path, start: &Knots<2>, increment: &Increment<2>) {
        let (d, growth) = (path.d, path.growth);
        if growth > 0.0 {
            // The old apex: below it, the elements born on the way lie on a straight line.
            self.push(0.0, V::zeros(), true);
            self.push(growth, d, true);
        } else if growth < 0.0 {
            let depth = -growth;
            let mut below = Knot { r: 0.0, u: [0.0; 2] };
            while self.died + 1 < start.len() && start[self.died].r <= depth {
                below = start[self.died];
                self.died += 1;
            }
            let above = &start[self.died];
            let part = (depth - below.r) / (above.r - below.r);
            self.cut = V::from(below.u) * (1.0 - part) + V::from(above.u) * part;
            let was = on_cone(above) && (self.died == 0 || on_cone(&below));
            self.push(0.0, self.cut + d, was);
        } else {
            self.push(0.0, d, true);
        }
        for knot in &start[self.died..] {
            self.push(knot.r + growth, V::from(knot.u) + d, on_cone(knot));
        }
        // The end of the curve is exact.
        if let [.., last] = &mut self.knots[1..] {
            last.r = increment.critical;
        }
    }

    #[inline(always)]
    fn push(&mut self, r: f64, v: V, was: bool) {
        // Knots that a large growth brings together are one.
        if self.knots.last().is_none_or(|below| r > below.r) {
            self.knots.push(Knot { r, u: v.into() });
            self.was.push(was);
        }
    }

    /// Which knots slip; the cone is convex, so that the path does not matter.
    #[inline(always)]
    fn find_slipping(&mut self, path: &Path) {
        let mut last = None;
        for (index, (knot, &was)) in self.knots.iter_mut().zip(&self.was).enumerate() {
            let (v, limit) = (V::from(knot.u), knot.r * knot.r);
            let squared = v.norm_squared();
            let mut slips = squared >= limit * AT_LIMIT && squared > 0.0;
            if slips && squared <= limit * OUTSIDE {
                slips = was && v.dot(&path.d) > squared.sqrt() * path.growth;
                if !slips && squared > limit {
                    knot.u = (v * (knot.r / squared.sqrt())).into();
                }
            }
            self.slips.push(slips);
            if slips {
                last = Some(index);
            }
        }
        if path.growth > 0.0 {
            self.slips[0] = self.slips[1];
        }
        if let Some(last) = last
            && last + 1 < self.knots.len()
        {
            let segment = Segment::new(&self.knots[last], &self.knots[last + 1]);
            self.top = segment.r + segment.slip_ends() * segment.width;
        }
    }

    /// What the dead dissipate, over the old T: an element of limit R dies when the share R / depth of the step is done, with
    /// v = u + d R / depth, and slips |v| in the share |v| / c before, c = d.v/|v| + depth: depth/2 int v.(v/c) k dR.
    #[cold]
    fn dissipation_of_dead<B: Backbone>(&self, path: &Path, curve: &Over<'_, B>, start: &Knots<2>) -> f64 {
        let depth = -path.growth;
        let cut = Knot { r: depth, u: self.cut.into() };
        let mut below = (0.0, V::zeros(), V::zeros(), Values::default());
        let mut sum = 0.0;
        let mut to = |r: f64, v: V| {
            let length = v.norm();
            let speed = if length > 0.0 { v.dot(&path.d) / length + depth } else { depth };
            // No element slips for longer than the step.
            let shared = v / speed.max(length).max(f64::MIN_POSITIVE);
            let at = curve.at(r);
            let (r0, v0, shared0, at0) = below;
            if r > r0 {
                let (slope, slope_shared) = ((v - v0) / (r - r0), (shared - shared0) / (r - r0));
                sum += slope.dot(&(shared * at.f - shared0 * at0.f))
                    + slope_shared.dot(&(v * at.f - v0 * at0.f))
                    - 2.0 * slope.dot(&slope_shared) * (at.integral - at0.integral);
            }
            below = (r, v, shared, at);
        };
        let mut previous = (0.0, V::zeros());
        for knot in start[..self.died].iter().chain([&cut]) {
            let v = V::from(knot.u) + path.d * (knot.r / depth);
            // Where |v| is least its direction changes fast.
            let rise = v - previous.1;
            let (along, squared) = (-previous.1.dot(&rise), rise.norm_squared());
            if along > 0.0 && along < squared {
                let part = along / squared;
                to(previous.0 + part * (knot.r - previous.0), previous.1 + rise * part);
            }
            to(knot.r, v);
            previous = (knot.r, v);
        }
        let (_, v, shared, at) = below;
        (sum - v.dot(&shared) * at.slope) * depth / 2.0
    }
}

/// A place of the curve at the end.
#[derive(Clone, Copy)]
struct Kept {
    r: f64,
    u: V,
    n: V,
    f: f64,
    kind: Kind,
}

/// Goes along the curve at the end from the apex outwards, and adds up what it gives.
struct Walk<'a, B> {
    path: &'a Path,
    curve: &'a Over<'a, B>,
    /// Square of the part of T that a chord may hide.
    tolerance: f64,
    /// How many places may be added as middles before the room for the rest is touched.
    middles: usize,
    /// The largest part of T that a chord hides for want of room.
    hidden: f64,
    /// The place last added, and the segment below it: secant of f, slope of u.
    last: Node,
    secant: f64,
    slope: V,
    kept: &'a mut ArrayVec<Kept, NODES>,
    /// Eqs. (1) and (2), over T.
    traction: V,
    stored: f64,
    /// sum (e_a - e_b)/h (L_b - L_a), and int e theta k dR.
    work: f64,
    shared: f64,
    /// Tangents over T; the part of the sticking knots is a multiple of the identity.
    by_slip: M,
    by_growth: V,
    sticking: f64,
}

impl<'a, B: Backbone> Walk<'a, B> {
    #[inline(always)]
    fn new(
        path: &'a Path,
        curve: &'a Over<'a, B>,
        kept: &'a mut ArrayVec<Kept, NODES>,
        tolerance: f64,
        trial: usize,
        apex: Node,
    ) -> Self {
        Walk {
            path,
            curve,
            tolerance: tolerance * tolerance,
            // Two fronts and a knot per segment must fit.
            middles: NODES - 3 * trial,
            hidden: 0.0,
            last: apex,
            secant: 0.0,
            slope: V::zeros(),
            kept,
            traction: V::zeros(),
            stored: 0.0,
            work: 0.0,
            shared: apex.slip * apex.share * apex.at.slope,
            by_slip: M::zeros(),
            by_growth: V::zeros(),
            sticking: 0.0,
        }
    }

    /// Adds the next place, with middles below it where the direction turns: a chord hides
    /// h/4 |n_b - n_a| |kink|, h = R_b - R_a, kink = change of f' half-way.
    #[inline(always)]
    fn refine(&mut self, next: Node) {
        let mut ahead = ArrayVec::<Node, { HALVINGS + 1 }>::new();
        ahead.push(next);
        while let Some(next) = ahead.last() {
            let last = &self.last;
            let mut middle = None;
            let slipping = |kind| kind == Kind::Slip;
            if next.kind != Kind::Stick
                && last.kind != Kind::Stick
                && (slipping(next.kind) || slipping(last.kind))
                && !(self.kept.is_empty() && self.path.growth > 0.0)
            {
                let half = 0.5 * (next.r - last.r);
                let kink = half * (last.at.slope - next.at.slope);
                let hidden = 0.0625 * (next.n - last.n).norm_squared() * kink * kink;
                if hidden > self.tolerance && half > SAME * self.path.critical {
                    if ahead.is_full() || self.middles == 0 {
                        self.hidden = self.hidden.max(hidden.sqrt());
                    } else {
                        middle = self.path.middle(self.curve, last, next);
                    }
                }
            }
            match middle {
                Some(node) => {
                    self.middles -= 1;
                    ahead.push(node);
                }
                None => {
                    let next = *next;
                    ahead.pop();
                    self.add(next);
                }
            }
        }
    }

    /// Adds the segment from the last place to the next one.
    #[inline(always)]
    fn add(&mut self, next: Node) {
        let last = &self.last;
        let width = next.r - last.r;
        let (mut secant, mut slope) = (next.at.slope, V::zeros());
        if width > 0.0 {
            let inverse = 1.0 / width;
            let df = next.at.f - last.at.f;
            secant = if width > SHORT * self.path.critical {
                df * inverse
            } else {
                0.5 * (last.at.slope + next.at.slope)
            };
            slope = (next.u - last.u) * inverse;
            self.traction += slope * df;
            self.stored += slope.dot(&(next.u * next.at.f - last.u * last.at.f))
                - slope.norm_squared() * (next.at.integral - last.at.integral);
            if last.slip > 0.0 || next.slip > 0.0 {
                let fall = (last.slip - next.slip) * inverse;
                self.work += fall * (next.at.loss - last.at.loss);
                if self.path.growth != 0.0 {
                    let rise = (next.share - last.share) * inverse;
                    self.shared += rise * (next.slip * next.at.f - last.slip * last.at.f)
                        - fall * (next.share * next.at.f - last.share * last.at.f)
                        + 2.0 * fall * rise * (next.at.integral - last.at.integral);
                }
            }
        }
        self.settle(secant, &slope);
        (self.last, self.secant, self.slope) = (next, secant, slope);
    }

    /// What the place last added gives to the tangents, now that the segment above it is known: the secant there is
    /// `secant`, the slope of u `slope`.
    #[inline(always)]
    fn settle(&mut self, secant: f64, slope: &V) {
        let node = &self.last;
        let (n, turn) = (node.n, &node.turn);
        let n_left = left(&n);
        let weight = self.secant - secant;
        let first = self.kept.is_empty();
        match &node.moves {
            None if node.kind == Kind::Stick => self.sticking += weight,
            None => {
                // du = n dG + n_left R d phi
                self.by_slip += n_left * turn.by_slip.transpose() * weight;
                self.by_growth += (n + n_left * turn.by_growth) * weight;
            }
            Some(moves) => {
                if node.kind == Kind::Front {
                    self.by_slip += moves.trial_by_slip * weight;
                    self.by_growth += moves.trial_by_growth * weight;
                } else if !first {
                    // du0 = dv - dd
                    let start = moves.trial_by_slip - M::identity();
                    let by_slip = turn.by_slip
                        + start.transpose() * turn.by_start
                        + moves.depth_by_slip * turn.by_depth;
                    let by_growth = turn.by_growth
                        + turn.by_start.dot(&moves.trial_by_growth)
                        + turn.by_depth * moves.depth_by_growth;
                    self.by_slip += (n_left * by_slip.transpose() - n * moves.depth_by_slip.transpose()) * weight;
                    self.by_growth += (n * (1.0 - moves.depth_by_growth) + n_left * by_growth) * weight;
                }
                // The place moves along the curve. Without any increment the apex does not: the side of a rising limit.
                let at_rest = first && self.path.growth == 0.0 && node.kind == Kind::Stick;
                if first && self.path.growth <= 0.0 && node.kind == Kind::Stick {
                    // Nothing slips: the elements below the first knot stick, too.
                    self.sticking += node.at.slope - secant;
                }
                if !at_rest {
                    let below = if first { V::zeros() } else { self.slope * (self.secant - node.at.slope) };
                    let along = below + slope * (node.at.slope - secant);
                    self.by_slip += along * moves.depth_by_slip.transpose();
                    self.by_growth += along * moves.depth_by_growth;
                }
            }
        }
        self.kept.push(Kept {
            r: node.r,
            u: node.u,
            n,
            f: node.at.f,
            kind: node.kind,
        });
    }

    /// After the last place nothing holds any more: f' is 0 there.
    #[inline(always)]
    fn finish(&mut self) {
        self.settle(0.0, &V::zeros());
    }

    /// D / T without the dead.
    #[inline(always)]
    fn dissipated(&self, gross: bool) -> f64 {
        let end = if gross { self.last.slip } else { 0.0 };
        self.work + end - 0.5 * self.path.growth * self.shared
    }

    /// Writes the knots that matter to `end`, at most `room`; gives the largest part of T that was given up.
    #[inline(always)]
    fn forget(&mut self, room: usize, end: &mut Knots<2>) -> f64 {
        let critical = self.path.critical;
        let tolerance = 0.25 * self.tolerance;
        let kept = &mut *self.kept;
        let mut importance = ArrayVec::<f64, NODES>::new();
        let mut needless = false;
        for k in 0..kept.len() {
            let value = importance_of(kept, k, critical, tolerance);
            needless |= value < 0.0;
            importance.push(value);
        }
        let mut given_up: f64 = 0.0;
        let remove = |kept: &mut ArrayVec<Kept, NODES>, importance: &mut ArrayVec<f64, NODES>, k: usize| {
            kept.remove(k);
            importance.remove(k);
            for beside in [k - 1, k] {
                importance[beside] = importance_of(kept, beside, critical, tolerance);
            }
        };
        if needless {
            let mut k = 1;
            while k + 1 < kept.len() {
                if importance[k] < 0.0 {
                    remove(kept, &mut importance, k);
                    k = (k - 1).max(1);
                } else {
                    k += 1;
                }
            }
        }
        while kept.len() - 1 > room {
            let mut least = 1;
            for k in 2..kept.len() - 1 {
                if importance[k] < importance[least] {
                    least = k;
                }
            }
            if importance[least] < KEEP {
                given_up = given_up.max(importance[least]);
            }
            remove(kept, &mut importance, least);
        }
        for place in &kept[1..] {
            end.push(Knot { r: place.r, u: place.u.into() });
        }
        given_up.max(0.0).sqrt()
    }
}

/// Square of the part of T that is lost with a place: the traction changes by |off the chord| |kink|, and on the cone the
/// chord would hide h/4 |n_c - n_a| |kink|. The ends of the curve stay; fronts stay where they are not doubled.
#[inline(always)]
fn importance_of(kept: &[Kept], k: usize, critical: f64, tolerance: f64) -> f64 {
    if k == 0 || k + 1 >= kept.len() {
        return KEEP;
    }
    let (a, b, c) = (&kept[k - 1], &kept[k], &kept[k + 1]);
    let (low, high) = (b.r - a.r, c.r - b.r);
    let near = SAME * b.r;
    if b.kind == Kind::Front {
        let doubled = (low <= near && a.kind == Kind::Front)
            || (high <= near && (k + 2 == kept.len() || c.kind == Kind::Front));
        return if b.r <= AT_APEX * critical || doubled { DROP } else { KEEP };
    }
    if low <= near || high <= near {
        return DROP;
    }
    let (over_low, over_high) = (1.0 / low, 1.0 / high);
    let kink = (c.f - b.f) * over_high - (b.f - a.f) * over_low;
    let bend = (b.u - a.u) * over_low - (c.u - b.u) * over_high;
    let along = low * high / (low + high);
    let mut importance = bend.norm_squared() * along * along * kink * kink;
    if importance < NEGLIGIBLE * NEGLIGIBLE {
        importance = DROP;
    }
    if b.kind == Kind::Slip && a.kind != Kind::Stick && c.kind != Kind::Stick {
        let turn = (c.n - a.n).norm_squared();
        let hidden = 0.0625 * (low + high) * (low + high) * turn * kink * kink;
        if importance > 0.0 || hidden > tolerance {
            return importance.max(hidden);
        }
    }
    importance
}

/// Drops the knot below the last that changes the traction least; gives that part of T.
#[cold]
fn forget_least<B: Backbone>(curve: &Over<'_, B>, knots: &mut Knots<2>) -> f64 {
    let (mut least, mut index) = (f64::INFINITY, 0);
    let mut below = (Knot { r: 0.0, u: [0.0; 2] }, 0.0);
    for k in 0..knots.len() - 1 {
        let (b, c) = (knots[k], knots[k + 1]);
        let [fb, fc] = [b.r, c.r].map(|r| curve.at(r).f);
        let (a, fa) = below;
        let (low, high) = (b.r - a.r, c.r - b.r);
        let kink = (fb - fa) / low - (fc - fb) / high;
        let part = low / (low + high);
        let off = V::from(b.u) - V::from(a.u) * (1.0 - part) - V::from(c.u) * part;
        let importance = off.norm() * kink.abs();
        if importance < least {
            (least, index) = (importance, k);
        }
        below = (b, fb);
    }
    knots.remove(index);
    least
}
