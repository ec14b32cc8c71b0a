//! What an image's file says of it: how much memory it takes, which compiler made it.

use std::io;
use std::path::Path;

use object::read::elf::{ElfFile32, ProgramHeader as _};
use object::{Object, ObjectSection};

/// What stands in memory where the stack has not been, word by word.
const PAINT: [u8; 4] = [0xCC; 4];

/// Sizes of an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Bytes of flash: code, constants, and what variables begin with.
    pub flash: u64,
    /// Bytes of memory that variables take, the heap among them.
    pub variables: u64,
    /// Versions of the compiler and the linker.
    pub compiler: String,
}

impl Image {
    /// Reads an image's ELF file; its memory begins at `memory`.
    ///
    /// # Errors
    /// When it cannot be read or is none.
    pub fn read(path: &Path, memory: u32) -> io::Result<Self> {
        let bytes = std::fs::read(path)
            .map_err(|e| io::Error::new(e.kind(), format!("{}: {e}", path.display())))?;
        let wrong = |e: object::Error| io::Error::other(format!("{}: {e}", path.display()));
        let file = ElfFile32::<object::LittleEndian>::parse(&*bytes).map_err(wrong)?;
        let endian = file.endian();
        let loaded = file.elf_program_headers().iter();
        let flash = loaded.map(|part| u64::from(part.p_filesz(endian))).sum();
        let variable = |s: &_| (memory..memory + 0x10_0000).contains(&address(s)) && !stack(s);
        let sections = file.sections().filter(variable);
        let ends = sections.map(|s| s.address() + s.size());
        let variables = ends.max().map_or(0, |end| end - u64::from(memory));
        let comment = file.section_by_name(".comment");
        let comment = comment.map_or(Ok(&[][..]), |s| s.data()).map_err(wrong)?;
        let text = String::from_utf8_lossy(comment);
        let rustc = text
            .split('\0')
            .find_map(|part| part.strip_prefix("rustc version "));
        Ok(Self {
            flash,
            variables,
            compiler: rustc.unwrap_or("unknown").to_owned(),
        })
    }
}

/// Whether it is what riscv-rt leaves to the stack, rather than a variable.
fn stack<'d>(section: &impl ObjectSection<'d>) -> bool {
    section.name() == Ok(".stack")
}

fn address<'d>(section: &impl ObjectSection<'d>) -> u32 {
    u32::try_from(section.address()).unwrap_or(u32::MAX)
}

/// Bytes between the variables and the deepest that the stack has been, from a look into the guest's memory.
pub fn free_of(memory: &[u8], image: &Image) -> usize {
    let above = memory.get(image.variables as usize..).unwrap_or_default();
    let words = above.chunks_exact(4);
    // The first words above the variables may belong to the last of them.
    let painted = words.skip_while(|word| *word != PAINT);
    4 * painted.take_while(|word| *word == PAINT).count()
}
