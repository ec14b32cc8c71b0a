//! The unit's guard alone, questioned by the rig: its decisions and what they cost.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use palpate_core::guard::{Guard, Plant};
use palpate_image::{ANSWER, Processor, QUESTION, answer};
use palpate_image_lm3s6965evb::settings::{LIMITS, WIRES};
use palpate_image_lm3s6965evb::{HEAP, Machine, start};

#[entry]
fn main() -> ! {
    let (mut machine, rig) = start();
    let Ok(mut guard) = Guard::last_word(LIMITS, Plant::default(), &WIRES, false) else {
        panic!("a plant that no wire can have");
    };
    HEAP.close();
    let mut question = [0; QUESTION];
    let mut told = [0; ANSWER];
    loop {
        if let Some(length) = rig.question(&mut question) {
            let (length, took) = answer(&mut guard, &question[..length], Machine::ticks, &mut told);
            rig.tell(took, &told[..length]);
        }
        machine.feed();
    }
}
