//! A Peltier module under a fingertip, its sink and its thermistors: the figures that both the emulated module and
//! the guard of a real one are given. The solver is the emulator's, the bounds are the guard's.

/// A Peltier module, its mount, and the skin on its face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeltierParameters {
    /// Seebeck coefficient of all couples, V/K.
    pub seebeck_v_k: f64,
    /// Electrical resistance, Ohm.
    pub resistance_ohm: f64,
    /// Thermal conductance between the faces, W/K.
    pub conductance_w_k: f64,
    /// Heat capacity of the face on the skin, J/K.
    pub face_j_k: f64,
    /// Heat capacity of the sink, J/K.
    pub sink_j_k: f64,
    /// Thermal resistance from the sink to the air, K/W.
    pub sink_k_w: f64,
    /// Thermal conductance from the face to the body, through skin, W/K.
    pub skin_w_k: f64,
    /// Time constant of a thermistor in face or sink, s.
    pub sensor_s: f64,
}

impl Default for PeltierParameters {
    /// A module of 10 x 10 mm with 17 couples, scaled from the vendor's CP1.0-127-06L (127 couples, 3 A, 15.4 V, 67
    /// K) at 300 K. Heat capacities, sink, skin and thermistors are assumed.
    fn default() -> Self {
        Self {
            seebeck_v_k: 6.87e-3,
            resistance_ohm: 0.534,
            conductance_w_k: 35.8e-3,
            face_j_k: 0.43,
            sink_j_k: 12.0,
            sink_k_w: 15.0,
            skin_w_k: 0.05,
            sensor_s: 0.3,
        }
    }
}

/// An NTC thermistor to ground under a resistor to the reference of a 12-bit converter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermistor {
    /// Resistance at 25 degrees C, Ohm.
    pub nominal_ohm: f64,
    /// The constant B, K.
    pub beta_k: f64,
    /// The resistor above the thermistor, Ohm.
    pub series_ohm: f64,
}

impl Thermistor {
    /// Highest code of the converter.
    pub const FULL_SCALE: u16 = 4095;
    /// Temperature at which [`Self::nominal_ohm`] holds, degrees C.
    pub const NOMINAL_C: f64 = 25.0;
}

impl Default for Thermistor {
    /// The common 10 kOhm part, B 3950 K, under 10 kOhm.
    fn default() -> Self {
        Self {
            nominal_ohm: 10e3,
            beta_k: 3950.0,
            series_ohm: 10e3,
        }
    }
}
