//! Words of settings files for closed lists. Most lists are the core's, which knows no text format: the types here
//! only state how its values are written.

use palpate_core::{contact, illusion, peltier, physics, render, skin, texture};
use serde::de::value::StrDeserializer;
use serde::de::{Deserialize, Deserializer, IntoDeserializer};

use super::wording::Misfit;

/// A closed list of words.
macro_rules! choice {
    ($(#[$doc:meta])* $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $text:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
        #[cfg_attr(test, derive(schemars::JsonSchema, serde::Serialize))]
        pub enum $name { $($(#[$variant_doc])* #[serde(rename = $text)] $variant),+ }
    };
}

/// The words for a closed list of the core's.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident for $remote:literal { $($(#[$variant_doc:meta])* $variant:ident = $text:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(serde::Deserialize)]
        #[cfg_attr(test, derive(schemars::JsonSchema, serde::Serialize))]
        #[serde(remote = $remote)]
        pub(super) enum $name { $($(#[$variant_doc])* #[serde(rename = $text)] $variant),+ }
    };
}

pub(super) use choice;

words! { /** Norms that make one weight of a taxel's axes. */ Norm for "contact::Norm" {
    /** Sum of absolute values. */ L1 = "l1",
    /** Euclidean. */ L2 = "l2",
    /** Largest absolute value. */ LInf = "linf",
}}
words! { /** Parts of the skin over which `kc` and `ki` apply. */ Scope for "contact::Scope" {
    /** Each module. */ Module = "module",
    /** The whole skin in one plane. */ Skin = "skin",
}}
words! { /** Laws that turn a place between wires into activations. */ Model for "illusion::IllusionModel" {
    /** The logarithmic phantom sensation of the thesis's (5.2). */ Phantom = "phantom",
    /** Square roots of shares. */ Energy = "energy",
    /** Shares. */ Linear = "linear",
    /** Squares of shares. */ Square = "square",
    /** Shares to a power between those of energy and linear, at one energy everywhere. */ Balanced = "balanced",
    /** Amplitudes and numbers of pulses that both centroids feel at the contact, within what heat allows. */ Inverse = "inverse",
    /** Three nearest wires by inverse distance (Park 2016). */ ThreeNearest = "three-nearest",
    /** A bell around each wire. */ Gaussian = "gaussian",
    /** The nearest wire alone. */ Nearest = "nearest",
}}
words! { /** Measures of the distance from a contact to a wire. */ Distances for "illusion::Distances" {
    /** Each axis on its own. */ Axes = "axes",
    /** The distance in the unrolled plane. */ Plane = "plane",
    /** Straight through space, on the display's surface. */ Space = "space",
}}
words! { /** Rules by which several contacts share wires. */ Sharing for "illusion::Sharing" {
    /** A wire follows the contact that asks most of it. */ Strongest = "strongest",
    /** Energies add up, to full drive at most. */ Sum = "sum",
    /** One contact after the other, onset by onset. */ Slices = "slices",
}}
words! { /** Styles in which `inverse` renders a contact. */ Style for "render::Style" {
    /** A vibration. */ Smooth = "smooth",
    /** Taps, which are felt more strongly at the same power. */ Tap = "tap",
    /** Taps while the contact rests, a vibration while it moves. */ Auto = "auto",
}}
words! { /** Laws for the missing one of duration and onset asynchrony. */ Timing for "illusion::TimingLaw" {
    /** 0.32 `tau_d` + 47.3 ms. */ TactileBrush = "tactile-brush",
    /** 115 ms between onsets. */ Fingerpad = "fingerpad",
}}
words! { /** Rules by which pulses are drawn. */ Draw for "texture::Draw" {
    /** Each period by itself, seeded. */ Bernoulli = "bernoulli",
    /** Error diffusion: the same density, never more than one pulse from it. */ Diffusion = "diffusion",
}}
words! { /** Mountings of the ends of a wire. */ Ends for "physics::Ends" {
    /** Ends that cannot turn. */ Clamped = "clamped",
    /** Ends that turn freely. */ Pinned = "pinned",
    /** Ends that cannot turn, with the wire pressed to its buckling load. */ Buckled = "buckled",
}}
words! { /** Materials of a thing. */ Material for "peltier::Material" {
    /** Aluminium. */ Metal = "metal",
    /** Soda-lime glass. */ Glass = "glass",
    /** Pine. */ Wood = "wood",
    /** Woven cotton. */ Cloth = "cloth",
}}
choice! { /** The axes that count. */ Axes {
    /** All three. */ Xyz = "xyz",
    /** The normal one. */ Z = "z",
}}

/// The core's axes are no closed list: a file has two words for them.
pub(super) mod axes {
    use super::{Axes, Deserialize, Deserializer, skin};

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<skin::Axes, D::Error> {
        Ok(match Axes::deserialize(from)? {
            Axes::Xyz => skin::Axes::XYZ,
            Axes::Z => skin::Axes::Z,
        })
    }

    #[cfg(test)]
    pub fn serialize<S: serde::Serializer>(axes: &skin::Axes, to: S) -> Result<S::Ok, S::Error> {
        let word = if *axes == skin::Axes::XYZ {
            Axes::Xyz
        } else {
            Axes::Z
        };
        serde::Serialize::serialize(&word, to)
    }
}

/// Distances where a file states them.
pub(super) mod distances {
    use super::{Deserializer, Distances, illusion};

    pub fn deserialize<'de, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Option<illusion::Distances>, D::Error> {
        Distances::deserialize(from).map(Some)
    }

    #[cfg(test)]
    pub fn serialize<S: serde::Serializer>(
        distances: &Option<illusion::Distances>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        match distances {
            Some(distances) => Distances::serialize(distances, to),
            None => to.serialize_none(),
        }
    }
}

/// The norm of this name, as files and the command line have it.
///
/// # Errors
/// The names there are.
pub fn norm(name: &str) -> Result<contact::Norm, String> {
    named(name, Norm::deserialize)
}

/// The scope of this name, as files and the command line have it.
///
/// # Errors
/// The names there are.
pub fn scope(name: &str) -> Result<contact::Scope, String> {
    named(name, Scope::deserialize)
}

/// The axes of this name, as files and the command line have it.
///
/// # Errors
/// The names there are.
pub fn axes_named(name: &str) -> Result<skin::Axes, String> {
    named(name, axes::deserialize)
}

fn named<'n, T>(
    name: &'n str,
    read: fn(StrDeserializer<'n, Misfit>) -> Result<T, Misfit>,
) -> Result<T, String> {
    read(name.into_deserializer()).map_err(|misfit| {
        let found = misfit.found.unwrap_or_else(|| format!("`{name}`"));
        format!("expected {}, found {found}", misfit.expected)
    })
}
