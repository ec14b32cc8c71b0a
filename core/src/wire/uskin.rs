//! uSkin taxel readings and commands on CAN.
