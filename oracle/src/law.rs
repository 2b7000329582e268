//! The whole law, plain and slow, for readers: not optimised, and written to be compared with the theory line by line.
//!
//! A contact point is a curve u(R), 0 <= R <= G: the elastic deflection of the slip element whose slip limit is R. The
//! curve is piecewise linear in knots. Every vector has two components here; one direction is a second component that
//! stays zero, so that the numbers of one direction come from the rules of two.
//!
//! With m = du/dR on a segment, and f, F = int f dR, L = 2 F - R f as functions of R:
//!
//! ```text
//! tau = T sum m (f_b - f_a)                                              (1) traction
//! psi = T sum [ m.(f_b u_b - f_a u_a) - |m|^2 (F_b - F_a) ]              (2) stored energy
//! G   = G_old (T / T_old)^(1/chi)  consistent rule; gcr proportional     (3) critical slip
//! ```

use crate::limit::Limit;
use crate::{Backbone, Status, quadrature::integrate};

/// A vector in the tangential plane.
pub type Plane = [f64; 2];
/// Derivatives of a number by the two slips and by G.
type Change = [f64; 3];

/// A knot of the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// Slip limit R, length.
    pub r: f64,
    /// Elastic deflection u, length.
    pub u: Plane,
}

/// The law of a point.
#[derive(Debug, Clone)]
pub struct Law {
    /// Traction of the first loading.
    pub backbone: Backbone,
    /// What the limit traction depends on.
    pub limit: Limit,
    /// Critical slip, at the reference pressure under the consistent rule; length.
    pub gcr: f64,
    /// Reference pressure of the consistent rule; 0 is the proportional rule.
    pub reference_pressure: f64,
    /// How many knots a point may keep.
    pub room: usize,
    /// eta: how fine a turning path is kept.
    pub resolution: f64,
    /// An element this near to its limit, relative, is on it: 1e-6 where the path turns; along a line nothing asks for it.
    pub near: f64,
}

/// What a point remembers.
#[derive(Debug, Clone, Default)]
pub struct Point {
    /// Pressure; 0 open.
    pub pressure: f64,
    /// Limit traction T.
    pub limit: f64,
    /// Stored energy per area.
    pub stored: f64,
    /// Length of the slip path.
    pub slip_length: f64,
    /// Part of T given up by the last increment.
    pub forgotten: f64,
    /// The curve, R ascending, the last at R = G.
    pub knots: Vec<Knot>,
    /// Contact status.
    pub status: Status,
}

/// What an increment gives.
#[derive(Debug, Clone, Copy)]
pub struct Response {
    /// Friction traction.
    pub traction: Plane,
    /// d traction_i / d slip_j.
    pub by_slip: [Plane; 2],
    /// d traction / d pressure.
    pub by_pressure: Plane,
    /// Dissipated in the increment, per area.
    pub dissipated: f64,
    /// Contact status.
    pub status: Status,
}

impl Law {
    /// Moves the point by slip d to a pressure; `factor` multiplies mu.
    pub fn step(&self, point: &mut Point, d: Plane, pressure: f64, factor: f64) -> Response {
        let old = std::mem::take(point);
        let open = Response {
            traction: [0.0; 2],
            by_slip: [[0.0; 2]; 2],
            by_pressure: [0.0; 2],
            dissipated: old.stored,
            status: Status::Open,
        };
        point.slip_length = old.slip_length;
        if pressure <= 0.0 {
            return open;
        }
        let limit = self.limit.at(pressure, factor, old.slip_length);
        let (chi, consistent) = (self.backbone.exponent(), self.reference_pressure > 0.0);
        let reference = self.limit.at(self.reference_pressure, 1.0, 0.0).traction;
        let fresh = if consistent && reference > 0.0 {
            self.gcr * (limit.traction / reference).powf(1.0 / chi)
        } else {
            self.gcr
        };
        *point = Point {
            pressure,
            limit: limit.traction,
            ..point.clone()
        };
        point.slip_length += norm(d);
        if consistent && limit.traction == 0.0 {
            point.status = Status::GrossSlip;
            return Response {
                status: point.status,
                ..open
            };
        }
        let mut start = old.knots.clone();
        let (mut limit_before, mut lost) = (old.limit, 0.0);
        if old.pressure == 0.0 {
            // A fresh start: G at the new pressure first, then the slip.
            start = vec![Knot {
                r: fresh,
                u: [0.0; 2],
            }];
            limit_before = limit.traction;
        }
        let before = start.last().map_or(0.0, |knot| knot.r);
        let critical = match consistent {
            false => self.gcr,
            true if start.is_empty() => fresh,
            true if limit.traction == limit_before => before,
            true => before * (limit.traction / limit_before).powf(1.0 / chi),
        };
        if !consistent && old.pressure > 0.0 && limit_before > 0.0 {
            // Deflections stay, tractions scale with T (Eq. 17 of the paper): energy may be created.
            lost = old.stored * (1.0 - limit.traction / limit_before);
        }
        let ratio = if consistent {
            limit_before / limit.traction
        } else {
            1.0
        };
        let moved = self.advance(start, d, before, critical, ratio, old.forgotten);
        let t = limit.traction;
        if old.pressure > 0.0 && d == [0.0; 2] && t == old.limit {
            // Nothing happens: a state that gave something up keeps the energy from before.
            *point = Point { pressure, ..old };
        } else {
            point.knots = moved.knots;
            point.stored = t * moved.stored;
            point.forgotten = moved.forgotten;
            point.status = moved.status;
        }
        Response {
            traction: moved.traction.map(|x| t * x),
            by_slip: moved.change.map(|row| [t * row[0], t * row[1]]),
            by_pressure: if consistent {
                // dG/dT = G / (chi T)
                moved
                    .change
                    .map(|row| limit.slope * critical / chi * row[2])
            } else {
                moved.traction.map(|x| limit.slope * x)
            },
            dissipated: t * moved.dissipated + lost,
            status: point.status,
        }
    }

    /// The curve under a slip d while G goes from `before` to `critical`, straight in both. Tractions over T.
    fn advance(
        &self,
        mut start: Vec<Knot>,
        d: Plane,
        before: f64,
        critical: f64,
        limit_ratio: f64,
        floor: f64,
    ) -> Moved {
        let curve = Curve {
            backbone: self.backbone,
            critical,
        };
        let old_curve = Curve {
            critical: before,
            ..curve
        };
        let growth = critical - before;
        let mut forgotten: f64 = 0.0;
        // 0. A new branch with no room for it: the least important knot goes first, so that one step and many agree.
        if start.len() == self.room && on_cone(&start[0], 1e-6) && dot(start[0].u, d) < 0.0 {
            let weight = |k: usize| {
                let below = if k > 0 { start[k - 1] } else { APEX };
                old_curve.importance(below, start[k], start[k + 1])
            };
            let least = (0..start.len() - 1).min_by(|&a, &b| weight(a).total_cmp(&weight(b)));
            let least = least.expect("a full memory has inner knots");
            forgotten = weight(least);
            start.remove(least);
        }

        // 1. Trial: every element moves by d, every limit by the growth. Elements are born or die at the apex.
        let mut trial: Vec<Trial> = Vec::new();
        let mut dead = 0.0;
        if growth > 0.0 {
            trial.push(Trial {
                r: 0.0,
                v: [0.0; 2],
                was: true,
            });
            trial.push(Trial {
                r: growth,
                v: d,
                was: true,
            });
        } else if growth == 0.0 {
            trial.push(Trial {
                r: 0.0,
                v: d,
                was: true,
            });
        } else {
            let depth = -growth;
            let died = start[..start.len() - 1]
                .iter()
                .filter(|knot| knot.r <= depth)
                .count();
            let (below, above) = (if died > 0 { start[died - 1] } else { APEX }, start[died]);
            let part = (depth - below.r) / (above.r - below.r);
            let cut = Knot {
                r: depth,
                u: mix(below.u, above.u, part),
            };
            let apex_was = on_cone(&above, self.near) && (died == 0 || on_cone(&below, self.near));
            trial.push(Trial {
                r: 0.0,
                v: add(cut.u, d),
                was: apex_was,
            });
            let gone: Vec<Knot> = start.drain(..died).chain([cut]).collect();
            dead = limit_ratio * died_with(&old_curve, &gone, d);
        }
        trial.extend(start.iter().map(|knot| Trial {
            r: knot.r + growth,
            v: add(knot.u, d),
            was: on_cone(knot, self.near),
        }));
        let last = trial.len() - 1;
        trial[last].r = critical;

        // 2. What slips: what is outside the cone, and what is on it and is pushed out.
        let mut slips = vec![false; trial.len()];
        for (knot, slips) in trial.iter_mut().zip(&mut slips) {
            let (square, limit) = (dot(knot.v, knot.v), knot.r * knot.r);
            let outside = square > limit * (1.0 + 2e-12);
            let at_limit = square >= limit * (1.0 - 2e-14) && square > 0.0;
            *slips = outside || (at_limit && knot.was && dot(knot.v, d) > square.sqrt() * growth);
            if !*slips && square > limit {
                knot.v = knot.v.map(|x| x * knot.r / square.sqrt());
            }
        }
        if growth > 0.0 {
            slips[0] = slips[1];
        }
        let outermost = slips.iter().rposition(|slips| *slips);
        let gross = outermost == Some(last);

        // 3. and 4. Fronts where slip ends or begins; what slips goes back onto the cone along the path of its element.
        let top = match outermost {
            None => 0.0,
            Some(k) if k == last => critical,
            Some(k) => front(&trial[k], &trial[k + 1], Crossing::Out, d).r,
        };
        let finest = if top > 0.0 {
            (self.resolution / 2.0 * curve.loss(top) / top).max(floor / 2.0)
        } else {
            0.0
        };
        let path = Path { d, growth };
        let apex = {
            let first = &trial[1];
            let mut node = Node::stick(&trial[0]);
            node.dx = [0.0, 0.0, 1.0];
            if growth <= 0.0 {
                node.du0 = scale(sub(first.v, trial[0].v), -1.0 / first.r).map(|x| [0.0, 0.0, x]);
            }
            if slips[0] {
                if growth < 0.0 {
                    let limit = -1e-13 * growth;
                    node = path.back(Node { r: limit, ..node });
                } else {
                    node.n = path.along();
                    node.excess = if growth == 0.0 { norm(d) } else { 0.0 };
                    node.share = 0.0;
                }
                node.kind = Kind::Slip;
            }
            (node.r, node.u, node.du) = (0.0, [0.0; 2], [[0.0; 3]; 2]);
            node
        };
        let mut nodes = vec![apex];
        let refine = |nodes: &mut Vec<Node>, node: Node| {
            let from = *nodes.last().expect("the apex");
            if !(growth > 0.0 && nodes.len() == 1) {
                halve(&curve, &path, finest, &from, &node, 9, nodes);
            }
            nodes.push(node);
        };
        for k in 1..trial.len() {
            let (a, b) = (&trial[k - 1], &trial[k]);
            if slips[k - 1] && !slips[k] {
                refine(&mut nodes, front(a, b, Crossing::Out, d));
            } else if !slips[k - 1] && slips[k] {
                nodes.push(front(a, b, Crossing::In, d));
            }
            if !slips[k] {
                nodes.push(Node::stick(b));
                continue;
            }
            if slips[k - 1] && !(b.was && nodes.last().is_some_and(|node| node.was)) {
                let (aa, bb, cc) = quadratic(a, b);
                if aa > 0.0 && bb < 0.0 && -bb < aa && bb * bb > aa * cc {
                    // The middle of the segment sticks between two fronts.
                    refine(&mut nodes, front(a, b, Crossing::Out, d));
                    nodes.push(front(a, b, Crossing::In, d));
                }
            }
            let node = path.back(Node::stick(b));
            refine(&mut nodes, node);
        }

        // 6. Traction, energies and tangents of this curve: Eqs. (1), (2) and their derivatives.
        let mut moved = Moved::default();
        let mut secants = vec![0.0];
        let mut slopes = vec![[0.0; 2]];
        let mut squares = vec![];
        for pair in nodes.windows(2) {
            let (a, b) = (&pair[0], &pair[1]);
            let h = b.r - a.r;
            let (fa, fb) = (curve.f(a.r), curve.f(b.r));
            let mean = (curve.slope(a.r) + curve.slope(b.r)) / 2.0;
            secants.push(if h > 1e-8 * critical {
                (fb - fa) / h
            } else {
                mean
            });
            if h <= 0.0 {
                slopes.push([0.0; 2]);
                continue;
            }
            let m = scale(sub(b.u, a.u), 1.0 / h);
            slopes.push(m);
            moved.traction = add(moved.traction, scale(m, fb - fa));
            moved.stored += dot(m, sub(scale(b.u, fb), scale(a.u, fa)))
                - dot(m, m) * (curve.integral(b.r) - curve.integral(a.r));
            // L' = f - R f'
            let lost = if curve.is_short(h) {
                integrate(h, |x, _| {
                    curve.f(a.r + x) - (a.r + x) * curve.slope(a.r + x)
                }) / h
            } else {
                (curve.lost(b.r) - curve.lost(a.r)) / h
            };
            moved.dissipated += (a.excess - b.excess) * lost;
        }
        squares.extend(
            nodes
                .iter()
                .map(|node| (node.r, [node.excess, 0.0], [node.share, 0.0])),
        );
        moved.dissipated += dead - growth / 2.0 * curve.squares(&squares);
        if gross {
            moved.dissipated += nodes.last().expect("the end").excess;
        }
        secants.push(0.0);
        slopes.push([0.0; 2]);
        for (k, node) in nodes.iter().enumerate() {
            let (below, above) = (secants[k], secants[k + 1]);
            let slope = curve.slope(node.r);
            for i in [0, 1] {
                let mut moving = slopes[k + 1][i] * (slope - above);
                if k > 0 {
                    moving += slopes[k][i] * (below - slope);
                }
                for j in 0..3 {
                    if k > 0 {
                        moved.change[i][j] += (below - above) * node.du[i][j];
                    }
                    // At rest the derivative by G is that of a rising limit: nothing moves.
                    if k > 0 || growth != 0.0 || slips[0] {
                        moved.change[i][j] += moving * node.dx[j];
                    }
                }
            }
        }
        if growth <= 0.0 && !slips[0] {
            // The apex has not been moved: the smallest slip makes a front there.
            for i in 0..2 {
                moved.change[i][i] += curve.slope(0.0) - secants[1];
            }
        }
        moved.status = match outermost {
            Some(_) if gross => Status::GrossSlip,
            Some(_) if curve.slope(top) < 0.99 * curve.slope(0.0) => Status::MicroSlip,
            _ => Status::Stick,
        };

        // 7. Knots that do not matter go; when more than there is room for are left, the least important.
        let mut k = 1;
        while k + 1 < nodes.len() {
            if curve.worth(&nodes[k - 1..k + 2], finest) < 0.0 {
                nodes.remove(k);
                k = (k - 1).max(1);
            } else {
                k += 1;
            }
        }
        while nodes.len() - 1 > self.room {
            let worth = |k: usize| curve.worth(&nodes[k - 1..k + 2], finest);
            let least = (1..nodes.len() - 1).min_by(|&a, &b| worth(a).total_cmp(&worth(b)));
            let least = least.expect("inner knots");
            if worth(least).is_finite() {
                forgotten = forgotten.max(worth(least));
            }
            nodes.remove(least);
        }
        moved.forgotten = forgotten;
        moved.knots = nodes[1..]
            .iter()
            .map(|node| Knot {
                r: node.r,
                u: node.u,
            })
            .collect();
        moved
    }
}

/// The curve at the end of an increment, over T.
#[derive(Default)]
struct Moved {
    knots: Vec<Knot>,
    traction: Plane,
    change: [Change; 2],
    stored: f64,
    dissipated: f64,
    forgotten: f64,
    status: Status,
}

const APEX: Knot = Knot {
    r: 0.0,
    u: [0.0; 2],
};

/// A knot before it is known what slips.
#[derive(Debug, Clone, Copy)]
struct Trial {
    r: f64,
    v: Plane,
    /// On the cone before the increment.
    was: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Stick,
    Slip,
    Front,
}

/// A knot of the new curve.
#[derive(Debug, Clone, Copy)]
struct Node {
    kind: Kind,
    r: f64,
    /// Trial deflection.
    v: Plane,
    was: bool,
    /// Deflection and its direction.
    u: Plane,
    n: Plane,
    /// Slip of the element, and the share of the increment that counts for it.
    excess: f64,
    share: f64,
    /// Derivatives: of the depth x = G - R, of the deflection before the increment, of the deflection.
    dx: Change,
    du0: [Change; 2],
    du: [Change; 2],
}

impl Node {
    fn stick(trial: &Trial) -> Node {
        Node {
            kind: Kind::Stick,
            r: trial.r,
            v: trial.v,
            was: trial.was,
            u: trial.v,
            n: [0.0; 2],
            excess: 0.0,
            share: 0.0,
            dx: [0.0; 3],
            du0: [[0.0; 3]; 2],
            du: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        }
    }
}

/// The increment: straight in slip and in G.
struct Path {
    d: Plane,
    growth: f64,
}

impl Path {
    /// Direction of the slip.
    fn along(&self) -> Plane {
        let length = norm(self.d);
        if length > 0.0 {
            scale(self.d, 1.0 / length)
        } else {
            [1.0, 0.0]
        }
    }

    /// The exact path of an element that slips: on the cone u = R n, u' = d - (n.d - growth) n. With psi the angle from d
    /// to n and da = |d| ds / R: cos psi = tanh z, sin psi = sech z, z' = a'.
    fn back(&self, node: Node) -> Node {
        let (d, growth, r) = (self.d, self.growth, node.r);
        let (length, e) = (norm(d), self.along());
        let ep = perpendicular(e);
        let before = r - growth;
        let mut end = Node {
            kind: Kind::Slip,
            ..node
        };
        if before <= 0.0 {
            // Born in this increment.
            let turn = if length > 0.0 { r / length } else { 0.0 };
            end.n = e;
            end.u = scale(e, r);
            end.du = [0, 1].map(|i| [turn * ep[i] * ep[0], turn * ep[i] * ep[1], e[i]]);
            end.excess = (length - growth).max(0.0);
            end.share = 1.0;
            return end;
        }
        // Where the slip starts: at the part s of the increment, with the limit R_h and in the direction h.
        let mut u0 = sub(node.v, d);
        let speed = length * length - growth * growth;
        let (mut n0, mut stretch) = ([0.0; 2], 1.0);
        let mut s = 0.0;
        if node.was {
            let long = norm(u0);
            if long > 0.0 {
                n0 = scale(u0, 1.0 / long);
                stretch = before / long;
                u0 = scale(n0, before);
                let b = dot(n0, d) - growth;
                if b < 0.0 {
                    s = -2.0 * before * b / speed;
                }
            }
        } else {
            let b = dot(u0, d) - before * growth;
            let c = (dot(u0, u0) - before * before).min(0.0);
            let q = (b * b - speed * c).max(0.0).sqrt();
            s = if b < 0.0 {
                (q - b) / speed
            } else {
                -c / (b + q)
            };
        }
        s = if s >= 0.0 { s.min(1.0) } else { 0.0 };
        let limit = before + s * growth;
        let at = add(u0, scale(d, s));
        let (h, long) = match norm(at) {
            long if long > 0.0 => (scale(at, 1.0 / long), if s > 0.0 { long } else { limit }),
            _ => (e, f64::INFINITY),
        };
        let m = 1.0 - s;
        let (c, w) = (dot(h, e), cross(e, h));
        let small = growth.abs() * m < 0.1 * (r + limit);
        let al = match growth {
            0.0 => m / limit,
            _ if small => (growth * m / limit).ln_1p() / growth,
            _ => (r / limit).ln() / growth,
        };
        let a = length * al;
        // N = cosh a + c sinh a, k = c cosh a + sinh a.
        let (n, n_less_1, k) = if a < 0.5 {
            let less = 2.0 * (a / 2.0).sinh().powi(2) + c * a.sinh();
            (1.0 + less, less, c * a.cosh() + a.sinh())
        } else {
            let grown = a.min(300.0).exp();
            let p = grown * if c < 0.0 { w * w / (1.0 - c) } else { 1.0 + c };
            let m = (1.0 - c) / grown;
            ((p + m) / 2.0, (p + m) / 2.0 - 1.0, (p - m) / 2.0)
        };
        let g = if length > 0.0 {
            n_less_1 / length
        } else {
            al * c
        };
        end.n = add(scale(e, k / n), scale(ep, w / n));
        end.u = scale(end.n, r);
        // R d(phi), phi the direction of u; the start of the slip has no share in it.
        let across = r / n * (g + c * s / long);
        let ahead = -r * (w / n) * (s / long + al);
        let moment = if small {
            integrate(m, |x, _| (s + x) / (limit + growth * x).powi(2))
        } else {
            ((r / limit).ln() + before / r - before / limit) / (growth * growth)
        };
        let by_growth = r * (w / n) * length * moment;
        let mut by_start = scale(perpendicular(h), r / (n * long));
        let mut by_depth = -(w / n) * length * m / limit;
        if node.was {
            by_start = scale(perpendicular(n0), r * stretch / (n * long) * dot(h, n0));
            by_depth -= r / (n * long) * cross(h, n0);
        }
        let across_n = perpendicular(end.n);
        for j in 0..3 {
            let mut turn =
                by_start[0] * node.du0[0][j] + by_start[1] * node.du0[1][j] + by_depth * node.dx[j];
            turn += if j < 2 {
                across * ep[j] + ahead * e[j]
            } else {
                by_growth
            };
            let longer = f64::from(u8::from(j == 2)) - node.dx[j];
            for i in [0, 1] {
                end.du[i][j] = end.n[i] * longer + across_n[i] * turn;
            }
        }
        // The slip e, and the share th that makes R e - growth/2 e th its work.
        let log = if n_less_1.abs() < 0.1 {
            n_less_1.ln_1p()
        } else {
            n.ln() + (a - 300.0).max(0.0)
        };
        let turned = k / n - c;
        if growth == 0.0 {
            (end.excess, end.share) = (r * log, 0.0);
        } else {
            let kap = 2.0 + 1.2 * c;
            let mut excess = growth * m * (a * turned / (12.0 + kap * a) - 1.0);
            if a > 0.0 {
                excess += m / al * log;
            }
            end.excess = excess.max(0.0);
            end.share = if excess > 0.0 {
                let late =
                    2.0 * m * m * length * turned / ((12.0 + kap * length * m / limit) * excess);
                // 2 int (1 - s) lam / int lam over a slip that lasts m.
                (m - late).clamp(0.0, 2.0 * m)
            } else {
                0.0
            };
        }
        end
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Crossing {
    /// Slips below, sticks above.
    Out,
    /// Sticks below, slips above.
    In,
}

/// |v|^2 - R^2 along a segment from a to b: A s^2 + 2 B s + C.
fn quadratic(a: &Trial, b: &Trial) -> (f64, f64, f64) {
    let (h, dv) = (b.r - a.r, sub(b.v, a.v));
    (
        dot(dv, dv) - h * h,
        dot(a.v, dv) - a.r * h,
        dot(a.v, a.v) - a.r * a.r,
    )
}

/// Where a segment of the trial curve crosses the cone.
fn front(a: &Trial, b: &Trial, crossing: Crossing, d: Plane) -> Node {
    let (aa, bb, cc) = quadratic(a, b);
    let q = (bb * bb - aa * cc).max(0.0).sqrt();
    let s = match crossing {
        Crossing::Out if bb > 0.0 => -(bb + q) / aa,
        Crossing::Out => cc.max(0.0) / (q - bb),
        Crossing::In if bb < 0.0 => (q - bb) / aa,
        Crossing::In => -cc / (bb + q),
    };
    let s = if s >= 0.0 { s.min(1.0) } else { 0.0 };
    let r = (a.r + s * (b.r - a.r)).min(b.r);
    let v = mix(a.v, b.v, s);
    let n = match norm(v) {
        long if long > 0.0 => scale(v, 1.0 / long),
        _ => Path { d, growth: 0.0 }.along(),
    };
    // It moves along the segment, whose slope is m: dx = (dG - n.dd) / (1 - n.m), du = dd - m dx.
    let m = scale(sub(b.v, a.v), 1.0 / (b.r - a.r));
    let mut slow = 1.0 - dot(n, m);
    if slow.abs() < 1e-9 {
        slow = 1e-9f64.copysign(slow);
    }
    let dx = [-n[0] / slow, -n[1] / slow, 1.0 / slow];
    let du0 = m.map(|m| dx.map(|dx| -m * dx));
    let mut du = du0;
    du[0][0] += 1.0;
    du[1][1] += 1.0;
    Node {
        kind: Kind::Front,
        r,
        v,
        was: false,
        u: scale(n, r),
        n,
        excess: 0.0,
        share: 0.0,
        dx,
        du0,
        du,
    }
}

/// Puts middles between two nodes until what the chord hides is no more than `finest`: P = h/4 |n_b - n_a| kink.
fn halve(
    curve: &Curve,
    path: &Path,
    finest: f64,
    a: &Node,
    b: &Node,
    depth: u32,
    nodes: &mut Vec<Node>,
) {
    if depth == 0
        || a.kind == Kind::Stick
        || b.kind == Kind::Stick
        || (a.kind == Kind::Front && b.kind == Kind::Front)
    {
        return;
    }
    let h = b.r - a.r;
    let kink = (curve.slope(a.r) - curve.slope(b.r)) / 2.0;
    if h / 4.0 * norm(sub(b.n, a.n)) * kink <= finest || h / 2.0 <= 1e-12 * curve.critical {
        return;
    }
    let mean = |x: Change, y: Change| [0, 1, 2].map(|j| (x[j] + y[j]) / 2.0);
    let middle = Trial {
        r: a.r + h / 2.0,
        v: mix(a.v, b.v, 0.5),
        was: a.was && b.was,
    };
    let square = dot(middle.v, middle.v);
    // The chord of two knots on the cone dips inside; the elements did not.
    let lifted = middle.was && a.kind == Kind::Slip && b.kind == Kind::Slip && square > 0.0;
    if !lifted && square < middle.r * middle.r * (1.0 - 2e-12) {
        return;
    }
    let middle = path.back(Node {
        dx: mean(a.dx, b.dx),
        du0: [mean(a.du0[0], b.du0[0]), mean(a.du0[1], b.du0[1])],
        ..Node::stick(&middle)
    });
    halve(curve, path, finest, a, &middle, depth - 1, nodes);
    nodes.push(middle);
    halve(curve, path, finest, &middle, b, depth - 1, nodes);
}

/// The backbone over slip limits R up to G.
#[derive(Clone, Copy)]
struct Curve {
    backbone: Backbone,
    critical: f64,
}

impl Curve {
    fn part(&self, r: f64) -> f64 {
        (r / self.critical).min(1.0)
    }

    fn f(&self, r: f64) -> f64 {
        self.backbone.traction(self.part(r))
    }

    fn slope(&self, r: f64) -> f64 {
        self.backbone.tangent(self.part(r)) / self.critical
    }

    fn integral(&self, r: f64) -> f64 {
        self.backbone.work(self.part(r)) * self.critical
    }

    /// Whether differences of F and L over this length are rounding.
    fn is_short(&self, h: f64) -> bool {
        h <= 1e-3 * self.critical
    }

    /// L by its definition: good for differences of order G.
    fn lost(&self, r: f64) -> f64 {
        2.0 * self.integral(r) - r * self.f(r)
    }

    /// L with all its digits at small R.
    fn loss(&self, r: f64) -> f64 {
        self.backbone.loss(self.part(r)) * self.critical
    }

    /// int a.b k dR with k = -f'', a and b linear between the given (R, a, b).
    fn squares(&self, points: &[(f64, Plane, Plane)]) -> f64 {
        let (_, a, b) = points[0];
        let mut sum = dot(a, b) * self.slope(0.0);
        for pair in points.windows(2) {
            let ((r0, a0, b0), (r1, a1, b1)) = (pair[0], pair[1]);
            let h = r1 - r0;
            if h <= 0.0 {
                continue;
            }
            // int (a.b)' f' dR = S [a.b] + 2 a'.b' [h (f_0 + f_1)/2 - (F_1 - F_0)], the bracket int (R - R_mean) f' dR
            let (f0, f1) = (self.f(r0), self.f(r1));
            let (secant, bent) = if self.is_short(h) {
                let bent = integrate(h, |x, y| (x - y) / 2.0 * self.slope(r0 + x));
                (integrate(h, |x, _| self.slope(r0 + x)) / h, bent / (h * h))
            } else {
                let mean = (self.integral(r1) - self.integral(r0)) / h;
                ((f1 - f0) / h, ((f0 + f1) / 2.0 - mean) / h)
            };
            sum +=
                secant * (dot(a1, b1) - dot(a0, b0)) + 2.0 * bent * dot(sub(a1, a0), sub(b1, b0));
        }
        sum
    }

    /// |off| |kink|: what the traction changes by when the knot b goes, over T.
    fn importance(&self, a: Knot, b: Knot, c: Knot) -> f64 {
        let (low, high) = (b.r - a.r, c.r - b.r);
        let slopes = sub(
            scale(sub(b.u, a.u), 1.0 / low),
            scale(sub(c.u, b.u), 1.0 / high),
        );
        norm(slopes) * low * high / (low + high) * self.kink(a.r, b.r, c.r)
    }

    fn kink(&self, a: f64, b: f64, c: f64) -> f64 {
        ((self.f(b) - self.f(a)) / (b - a) - (self.f(c) - self.f(b)) / (c - b)).abs()
    }

    /// What the middle of three nodes is worth, over T: negative when it is not needed, infinite when it must stay.
    fn worth(&self, three: &[Node], finest: f64) -> f64 {
        let (a, b, c) = (&three[0], &three[1], &three[2]);
        let (low, high) = (b.r - a.r, c.r - b.r);
        let (at_low, at_high) = (low <= 1e-12 * b.r, high <= 1e-12 * b.r);
        let last = c.r >= self.critical;
        if b.kind == Kind::Front {
            let doubled = at_low && a.kind == Kind::Front;
            let covered = at_high && (last || c.kind == Kind::Front);
            return if b.r <= 1e-15 * self.critical || doubled || covered {
                -1.0
            } else {
                f64::INFINITY
            };
        }
        if at_low || at_high {
            return -1.0;
        }
        let [ka, kb, kc] = [a, b, c].map(|node| Knot {
            r: node.r,
            u: node.u,
        });
        let jump = self.importance(ka, kb, kc);
        let mut hidden = 0.0;
        if b.kind == Kind::Slip && a.kind != Kind::Stick && c.kind != Kind::Stick {
            hidden = (low + high) / 4.0 * norm(sub(c.n, a.n)) * self.kink(a.r, b.r, c.r);
        }
        if jump < 1e-14 && hidden <= finest / 2.0 {
            -1.0
        } else {
            jump.max(hidden)
        }
    }
}

/// What the dying elements dissipate, over the old T: an element of limit R dies at the share R / depth of the increment with
/// v = u + d R / depth, and has slipped by |v| in the share |v| / c of it, c = v.d / |v| + depth.
fn died_with(curve: &Curve, gone: &[Knot], d: Plane) -> f64 {
    let depth = gone[gone.len() - 1].r;
    let shared = |v: Plane| {
        let long = norm(v);
        let c = if long > 0.0 { dot(v, d) / long } else { 0.0 } + depth;
        scale(
            v,
            if c > long {
                1.0 / c
            } else if long > 0.0 {
                1.0 / long
            } else {
                0.0
            },
        )
    };
    let mut points = vec![(0.0, [0.0; 2], [0.0; 2])];
    let mut from = (0.0, [0.0; 2]);
    for knot in gone {
        let to = (knot.r, add(knot.u, scale(d, knot.r / depth)));
        // A part is split where |v| is least.
        let rise = sub(to.1, from.1);
        let z = -dot(from.1, rise) / dot(rise, rise);
        if z > 0.0 && z < 1.0 {
            let v = mix(from.1, to.1, z);
            points.push((from.0 + z * (to.0 - from.0), v, shared(v)));
        }
        points.push((to.0, to.1, shared(to.1)));
        from = to;
    }
    let (r, a, b) = points[points.len() - 1];
    depth / 2.0 * (curve.squares(&points) - dot(a, b) * curve.slope(r))
}

fn on_cone(knot: &Knot, near: f64) -> bool {
    dot(knot.u, knot.u) >= knot.r * knot.r * (1.0 - 2.0 * near)
}

fn dot(a: Plane, b: Plane) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Plane, b: Plane) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn norm(a: Plane) -> f64 {
    a[0].hypot(a[1])
}

fn add(a: Plane, b: Plane) -> Plane {
    [a[0] + b[0], a[1] + b[1]]
}

fn sub(a: Plane, b: Plane) -> Plane {
    [a[0] - b[0], a[1] - b[1]]
}

fn scale(a: Plane, by: f64) -> Plane {
    a.map(|x| x * by)
}

fn mix(a: Plane, b: Plane, part: f64) -> Plane {
    add(a, scale(sub(b, a), part))
}

/// A quarter turn to the left.
fn perpendicular(a: Plane) -> Plane {
    [-a[1], a[0]]
}
