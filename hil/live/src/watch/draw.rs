//! A view on a grid of characters: skin on the left, contacts and wires on the right, the story below.

use super::grid::{Color, Grid, Style};
use super::heat::{Raster, look};
use super::view::View;

/// Smallest screen that shows everything.
pub const SMALLEST: (u16, u16) = (80, 24);
/// Cells of the skin, two characters each.
const SKIN: (u16, u16) = (17, 15);
/// Column at which the right half begins.
const RIGHT: u16 = 37;
/// Rows of contacts and of wires.
const CONTACTS: usize = 4;
const WIRES: usize = 8;

fn bold() -> Style {
    Style {
        bold: true,
        ..Style::default()
    }
}

fn dim() -> Style {
    Style {
        dim: true,
        ..Style::default()
    }
}

fn seconds(us: u64) -> String {
    format!("{}.{:03}", us / 1_000_000, us % 1_000_000 / 1000)
}

/// A value of thousandths with one digit, or a dash.
fn celsius(milli: Option<i32>) -> String {
    milli.map_or("-".into(), |mc| format!("{:.1}", f64::from(mc) / 1e3))
}

/// Draws a view on so many columns and rows; `raster` is the skin's, made for [`skin`].
pub fn draw(view: &View, raster: &Raster, (columns, rows): (u16, u16)) -> Grid {
    let mut grid = Grid::new((columns, rows));
    if columns < SMALLEST.0 || rows < SMALLEST.1 {
        let text = format!(
            "80x24 needed, {columns}x{rows} here; the run goes on ({} s)",
            seconds(view.now_us)
        );
        grid.put(0, 0, &text, Style::default());
        return grid;
    }
    head(view, &mut grid);
    skin(view, raster, &mut grid);
    contacts(view, &mut grid);
    wires(view, &mut grid);
    foot(view, &mut grid);
    grid
}

/// Cells for the skin.
pub const fn skin_size() -> (u16, u16) {
    SKIN
}

fn head(view: &View, grid: &mut Grid) {
    grid.put(0, 0, &view.title, bold());
    let time = format!("{} of {} s", seconds(view.now_us), seconds(view.end_us));
    let x = grid.columns.saturating_sub(time.len() as u16);
    grid.put(x.saturating_sub(1), 0, " ", bold());
    grid.put(x, 0, &time, bold());
    let counts = format!(
        "{} frames at {:.1} Hz   {} stimuli",
        view.frames,
        view.rate_hz(),
        view.stimuli
    );
    grid.put(0, 1, &counts, Style::default());
    if let Some((display, of)) = view.which {
        let text = format!("display {} of {of}; Tab shows the next", display + 1);
        grid.put(0, 2, &text, Style::default());
    }
    if !view.texture.is_empty() {
        let text = format!("texture {}", view.texture);
        grid.put(0, 2, &text, Style::default());
    }
    let style = match view.limited {
        0 => Style::default(),
        _ => Style::of_color(Color::Yellow),
    };
    grid.put(RIGHT, 1, &format!("{} limiter events", view.limited), style);
}

fn skin(view: &View, raster: &Raster, grid: &mut Grid) {
    let peak = view
        .counts
        .iter()
        .copied()
        .filter(|c| c.is_finite())
        .fold(0.0, f32::max);
    grid.put(
        0,
        3,
        &format!("{} taxels, at most {peak:.0} counts", view.taxels.len()),
        dim(),
    );
    for row in 0..raster.rows {
        for column in 0..raster.columns {
            if let Some(counts) = raster.counts(column, row, &view.counts) {
                let (shade, color) = look(counts, peak);
                let text: String = [shade, shade].iter().collect();
                grid.put(2 * column, 4 + row, &text, Style::of_color(color));
            }
        }
    }
    for contact in &view.contacts {
        let (column, row) = raster.cell(view.place(contact));
        let digit = format!("{:02}", contact.id % 100);
        let style = Style {
            reversed: true,
            ..bold()
        };
        grid.put(2 * column, 4 + row, &digit, style);
    }
}

fn contacts(view: &View, grid: &mut Grid) {
    let title = "contact module    x mm    y mm  counts lvl";
    grid.put(RIGHT, 3, title, dim());
    for (y, contact) in (4..).zip(view.contacts.iter().take(CONTACTS)) {
        let mm = |um: i32| f64::from(um) / 1e3;
        let text = format!(
            "{:>7} {:>6} {:>7.2} {:>7.2}  {:>6} {:>3}",
            contact.id,
            contact.module,
            mm(contact.place.x),
            mm(contact.place.y),
            contact.counts,
            contact.level
        );
        grid.put(RIGHT, y, &text, Style::default());
    }
    more(grid, 4, view.contacts.len(), CONTACTS);
}

/// Writes the number of rows that a table has no room for, in the row below it.
fn more(grid: &mut Grid, top: u16, there: usize, shown: usize) {
    if there > shown {
        let text = format!("   and {} more", there - shown);
        grid.put(RIGHT, top + shown as u16, &text, dim());
    }
}

fn wires(view: &View, grid: &mut Grid) {
    const TOP: u16 = 10;
    grid.put(
        RIGHT,
        TOP - 1,
        "wire  output   duty         wire C  skin C",
        dim(),
    );
    // With more wires than rows, those that are driven come first.
    let mut order: Vec<usize> = (0..view.wires.len()).collect();
    if order.len() > WIRES {
        order.sort_by_key(|w| (!view.is_driven(&view.wires[*w]), *w));
    }
    for (y, index) in (TOP..).zip(order.into_iter().take(WIRES)) {
        let wire = &view.wires[index];
        let driven = view.is_driven(wire);
        let ticks = if driven { wire.ticks } else { 0 };
        // A bar of eight for 4 %: the longest pulse that the guard lets pass is shorter.
        let bar = "#".repeat((usize::from(ticks) * 8).div_ceil(164).min(8));
        let text = format!(
            "{index:>4}  {:>2}:{:<2}  {:>5.2} % {bar:<8}{:>6}  {:>6}",
            wire.board,
            wire.channel,
            f64::from(ticks) * 100.0 / 4096.0,
            celsius(wire.wire_mc),
            celsius(wire.skin_mc)
        );
        let style = if driven { bold() } else { Style::default() };
        grid.put(RIGHT, y, &text, style);
    }
    more(grid, TOP, view.wires.len(), WIRES);
}

fn foot(view: &View, grid: &mut Grid) {
    let bottom = grid.rows;
    let top = 4 + SKIN.1;
    let buses = view.buses.len().min(2);
    for (y, bus) in (top..).zip(view.buses.iter().take(buses)) {
        grid.put(0, y, bus, Style::default());
    }
    if view.buses.len() > buses {
        let text = format!("and {} buses more", view.buses.len() - buses);
        grid.put(60, top + 1, &text, dim());
    }
    let first = top + buses as u16;
    let rows = usize::from(bottom.saturating_sub(first));
    let skip = view.story.len().saturating_sub(rows);
    for (y, (t_us, text)) in (first..).zip(view.story.iter().skip(skip)) {
        let style = if text.starts_with("limiter") {
            Style::of_color(Color::Yellow)
        } else {
            Style::default()
        };
        grid.put(0, y, &format!("{:>9} {text}", seconds(*t_us)), style);
    }
    let hint = "q ends the run";
    let x = grid.columns - hint.len() as u16;
    grid.put(x, 2, hint, dim());
}
