//! The first virtio card of the machine, as smoltcp wants it: one frame at a time.

use core::ptr::{self, NonNull};
use core::sync::atomic::{AtomicUsize, Ordering};

use palpate_image::Register;
use palpate_image::udp::Card;
use riscv::register::mie;
use smoltcp::phy::{Checksum, Device, DeviceCapabilities, Medium, RxToken, TxToken};
use smoltcp::time::Instant;
use smoltcp::wire::{EthernetAddress, HardwareAddress};
use virtio_drivers::device::net::VirtIONetRaw;
use virtio_drivers::transport::mmio::{MmioTransport, VirtIOHeader};
use virtio_drivers::{BufferDirection, Hal, PAGE_SIZE, PhysAddr};

/// Address of the card's registers.
const CARD: usize = 0x1000_1000;
const CARD_LENGTH: usize = 0x1000;
/// Bit 0: the card has used a buffer.
const USED: Register = Register(CARD + 0x60);
/// The interrupt controller: priority and number of the card's interrupt, and what the processor takes.
const INTERRUPT: u32 = 1;
const PRIORITY: Register = Register(0x0C00_0000 + 4 * INTERRUPT as usize);
const ENABLE: Register = Register(0x0C00_2000);
const CLAIM: Register = Register(0x0C20_0004);
/// Rings and frames of the card, in memory that the image is not linked to: no microcontroller has a card of this kind.
const MEMORY: usize = 0x8041_0000;
/// A header and the longest frame; the driver takes no shorter buffer for what comes.
const BUFFER: usize = 1526;
/// Longest frame without its check sequence.
const FRAME: usize = 1514;

/// Address of the next page of the card's memory.
static PAGES: AtomicUsize = AtomicUsize::new(MEMORY);

fn pages(count: usize) -> NonNull<u8> {
    // One thread: no other program takes pages in between.
    let at = PAGES.load(Ordering::Relaxed);
    PAGES.store(at + count * PAGE_SIZE, Ordering::Relaxed);
    // SAFETY: memory of the machine that no variable and no other page has.
    unsafe {
        ptr::write_bytes(at as *mut u8, 0, count * PAGE_SIZE);
        NonNull::new_unchecked(at as *mut u8)
    }
}

/// A page of the card's memory as a buffer.
fn buffer<const SIZE: usize>() -> &'static mut [u8; SIZE] {
    // SAFETY: a page of its own, for ever, which is longer.
    unsafe { pages(1).cast().as_mut() }
}

/// The machine's memory, as the driver wants it: addresses are those of the bus.
struct Machine;

// SAFETY: pages are zeroed, apart from each other and never given back; every address is one of the bus as well.
unsafe impl Hal for Machine {
    fn dma_alloc(count: usize, _: BufferDirection) -> (PhysAddr, NonNull<u8>) {
        let page = pages(count);
        (page.as_ptr() as PhysAddr, page)
    }

    unsafe fn dma_dealloc(_: PhysAddr, _: NonNull<u8>, _: usize) -> i32 {
        0
    }

    unsafe fn mmio_phys_to_virt(at: PhysAddr, _: usize) -> NonNull<u8> {
        // SAFETY: an address of registers, which is not null.
        unsafe { NonNull::new_unchecked(at as *mut u8) }
    }

    unsafe fn share(buffer: NonNull<[u8]>, _: BufferDirection) -> PhysAddr {
        buffer.cast::<u8>().as_ptr() as PhysAddr
    }

    unsafe fn unshare(_: PhysAddr, _: NonNull<[u8]>, _: BufferDirection) {}
}

type Driver = VirtIONetRaw<Machine, MmioTransport<'static>, 4>;

/// The card.
pub struct Ethernet {
    driver: Driver,
    comes: &'static mut [u8; BUFFER],
    goes: &'static mut [u8; FRAME],
    /// The number under which the card has the buffer for what comes.
    lent: Option<u16>,
}

impl Ethernet {
    /// Switches the card on.
    ///
    /// # Panics
    /// On a machine without the card.
    pub fn start() -> Self {
        PRIORITY.write(1);
        ENABLE.write(1 << INTERRUPT);
        let driver = NonNull::new(CARD as *mut VirtIOHeader).and_then(|header| {
            // SAFETY: the registers of the machine's first card, for ever.
            let transport = unsafe { MmioTransport::new(header, CARD_LENGTH) };
            Driver::new(transport.ok()?).ok()
        });
        let Some(driver) = driver else {
            panic!("no network card");
        };
        Self {
            driver,
            comes: buffer(),
            goes: buffer(),
            lent: None,
        }
    }

    /// Lets a frame that comes from now on end the processor's rest.
    pub fn listen() {
        // SAFETY: a rest takes no interrupt.
        unsafe { mie::set_mext() };
    }

    /// Lets frames end no rest any more.
    pub fn ignore() {
        // SAFETY: as above.
        unsafe { mie::clear_mext() };
        // Claimed and done with; as long as the card has something to say, it waits again.
        CLAIM.write(CLAIM.read());
    }

    /// Tells whether the card has used a buffer.
    pub fn is_waiting() -> bool {
        USED.read() & 1 != 0
    }

    /// Takes the oldest frame; returns its place in the buffer.
    fn take(&mut self) -> Option<(usize, usize)> {
        // Before the look: a frame that comes afterwards is said again.
        self.driver.ack_interrupt();
        let Some(lent) = self.lent else {
            // SAFETY: it is touched again when the card has given it back.
            self.lent = unsafe { self.driver.receive_begin(self.comes) }.ok();
            return None;
        };
        self.driver.poll_receive()?;
        self.lent = None;
        // SAFETY: the buffer that was lent under this number.
        unsafe { self.driver.receive_complete(lent, self.comes) }.ok()
    }
}

/// A frame that came.
#[derive(Debug)]
pub struct Received<'a>(&'a [u8]);

impl RxToken for Received<'_> {
    fn consume<R, F: FnOnce(&[u8]) -> R>(self, use_it: F) -> R {
        use_it(self.0)
    }
}

/// Room for a frame that goes.
pub struct Sent<'a>(&'a mut Driver, &'a mut [u8; FRAME]);

impl TxToken for Sent<'_> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, length: usize, fill: F) -> R {
        let frame = &mut self.1[..length.min(FRAME)];
        let result = fill(frame);
        // One that cannot be sent is lost, as any frame may be.
        let _ = self.0.send(frame);
        result
    }
}

impl Card for Ethernet {
    fn address(&self) -> HardwareAddress {
        HardwareAddress::Ethernet(EthernetAddress(self.driver.mac_address()))
    }

    fn is_waiting(&self) -> bool {
        Self::is_waiting() || self.lent.is_none()
    }
}

impl Device for Ethernet {
    type RxToken<'a> = Received<'a>;
    type TxToken<'a> = Sent<'a>;

    fn receive(&mut self, _: Instant) -> Option<(Received<'_>, Sent<'_>)> {
        let (head, length) = self.take()?;
        let frame = self.comes.get(head..head + length)?;
        Some((Received(frame), Sent(&mut self.driver, self.goes)))
    }

    fn transmit(&mut self, _: Instant) -> Option<Sent<'_>> {
        Some(Sent(&mut self.driver, self.goes))
    }

    fn capabilities(&self) -> DeviceCapabilities {
        let mut capabilities = DeviceCapabilities::default();
        capabilities.medium = Medium::Ethernet;
        capabilities.max_transmission_unit = FRAME;
        capabilities.max_burst_size = Some(1);
        // The seal says more of a datagram than UDP's sum does.
        capabilities.checksum.udp = Checksum::Tx;
        capabilities
    }
}
