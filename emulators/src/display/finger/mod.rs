//! The finger under one wire: half-cylinder shells from the wire's surface to 8 mm, evenly
//! spaced in ln r, and the heat path from wire to tissue. Geometry only; `solver` computes with it.

pub mod dose;

use core::f64::consts::PI;
use palpate_core::physics::{
    DEPTH_DEEP_M, DEPTH_SHALLOW_M, ParameterError, TissueParameters, WireParameters,
};

/// Shells of tissue under a wire.
const SHELLS: usize = 16;
/// Temperatures of one wire and its tissue: node 0 is the wire.
pub const NODES: usize = SHELLS + 1;

/// A depth at which the tissue's temperature is watched: two neighbouring nodes and their weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depth {
    /// The shallower of the two nodes.
    pub node: usize,
    /// Weight of the deeper one, linear in ln r; the shallower has the rest.
    pub weight: f64,
}

impl Depth {
    /// The temperature at the depth, from all node temperatures.
    pub fn temperature(&self, nodes: &[f64; NODES]) -> f64 {
        nodes[self.node] * (1.0 - self.weight) + nodes[self.node + 1] * self.weight
    }
}

/// Heat capacities and conductances of one wire and the tissue under it: a chain with the wire at one
/// end and the body at the other.
#[derive(Clone, Debug, PartialEq)]
pub struct ThermalNetwork {
    /// Heat capacity of each node, J/K; node 0 without latent heat.
    pub capacity: [f64; NODES],
    /// Conductance from node i to node i + 1, W/K; the last one leads to the body.
    pub chain: [f64; NODES],
    /// Conductance from the wire to the air, W/K.
    pub air: f64,
    /// Conductance from the wire to ends and mount, W/K.
    pub ends: f64,
    /// Temperature of the air, degrees C.
    pub air_c: f64,
    /// Temperature of ends and mount, degrees C.
    pub ends_c: f64,
    /// Temperature of the body, degrees C; the base that the solver counts from.
    pub body_c: f64,
    /// 0.1 mm under the tissue's surface.
    pub shallow: Depth,
    /// 0.4 mm under the tissue's surface.
    pub deep: Depth,
}

impl ThermalNetwork {
    /// The network of one wire on one finger.
    ///
    /// # Errors
    /// A parameter that cannot be computed with.
    pub fn new(wire: &WireParameters, tissue: &TissueParameters) -> Result<Self, ParameterError> {
        wire.check()?;
        tissue.check()?;
        let r0 = wire.diameter_m / 2.0;
        if tissue.outer_radius_m <= r0 + 2.0 * DEPTH_DEEP_M {
            return Err(ParameterError {
                name: "outer_radius_m",
            });
        }
        let length = wire.length_m;
        let step = libm::log(tissue.outer_radius_m / r0) / SHELLS as f64;
        let boundary = |i: usize| r0 * libm::exp(step * i as f64);
        let node = |i: usize| r0 * libm::exp(step * (i as f64 + 0.5));
        let conductivity = |i: usize| {
            let inner = node(i) - r0 > tissue.outer_depth_m;
            if inner {
                tissue.inner_conductivity
            } else {
                tissue.outer_conductivity
            }
        };
        // Thermal resistance of half a cylinder's shell from `a` to `b`, K/W.
        let shell = |a: f64, b: f64, k: f64| libm::log(b / a) / (PI * k * length);

        let mut capacity = [wire.heat_capacity(); NODES];
        let mut chain = [0.0; NODES];
        let surface = PI * wire.diameter_m * length;
        let touching = tissue.contact_h * surface * tissue.contact_fraction;
        if touching > 0.0 {
            chain[0] = 1.0 / (1.0 / touching + shell(r0, node(0), conductivity(0)));
        }
        for i in 0..SHELLS {
            let (inner, outer) = (boundary(i), boundary(i + 1));
            capacity[i + 1] =
                tissue.heat_capacity * PI / 2.0 * (outer * outer - inner * inner) * length;
            let mut path = shell(node(i), outer, conductivity(i));
            if i + 1 < SHELLS {
                path += shell(outer, node(i + 1), conductivity(i + 1));
            }
            chain[i + 1] = 1.0 / path;
        }
        let depth = |depth_m: f64| {
            let place = libm::log((r0 + depth_m) / r0) / step - 0.5;
            let index = libm::floor(place).clamp(0.0, (SHELLS - 2) as f64);
            Depth {
                node: index as usize + 1,
                weight: (place - index).clamp(0.0, 1.0),
            }
        };
        Ok(Self {
            capacity,
            chain,
            air: wire.air_h * surface * (1.0 - tissue.contact_fraction),
            ends: wire.ends_w_per_k() + wire.mount_w_per_k,
            air_c: tissue.air_c,
            ends_c: wire.ends_c,
            body_c: tissue.body_c,
            shallow: depth(DEPTH_SHALLOW_M),
            deep: depth(DEPTH_DEEP_M),
        })
    }

    /// Heat that flows into the wire from air and ends when it is at body temperature, W.
    pub(crate) fn rest_inflow(&self) -> f64 {
        self.air * (self.air_c - self.body_c) + self.ends * (self.ends_c - self.body_c)
    }

    /// dT/dt of every node, K/s: the plain right-hand side, for solvers to compare with.
    /// `wire_w` heats the wire, whose heat capacity is `wire_capacity`.
    pub fn rate(&self, t: &[f64; NODES], wire_w: f64, wire_capacity: f64) -> [f64; NODES] {
        let mut flow = [0.0; NODES];
        flow[0] = wire_w + self.air * (self.air_c - t[0]) + self.ends * (self.ends_c - t[0]);
        for i in 0..NODES {
            let next = if i + 1 < NODES { t[i + 1] } else { self.body_c };
            let q = self.chain[i] * (t[i] - next);
            flow[i] -= q;
            if i + 1 < NODES {
                flow[i + 1] += q;
            }
        }
        for (i, f) in flow.iter_mut().enumerate() {
            *f /= if i == 0 {
                wire_capacity
            } else {
                self.capacity[i]
            };
        }
        flow
    }
}
