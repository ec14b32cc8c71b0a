//! Principles by which a skin measures.

use super::words::choice;

choice! { /** Principles by which a skin's taxels measure. Its boards, if it has any, speak that family's protocol. */ Transducer {
    /** Magnets over Hall chips: three axes of 16 bits, uSkin boards. */ Magnetic = "magnetic",
    /** Capacitors: one axis of 8 bits, MTB boards of the iCub's kind. */ Capacitive = "capacitive",
    /** Blocks of a camera's picture: one axis of 8 bits, no boards. */ Camera = "camera",
    /** Cells of proximity (x), acceleration (y) and normal force (z), 16 bits, no boards. */ Cells = "cells",
}}
