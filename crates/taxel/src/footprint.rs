//! The memory that a model takes on a microcontroller, and the rows of a run that fit one.

use serde::Serialize;
use taxel_firmware::{Core, Library, Size};
use taxel_judge::{Case, Need, Room};
use taxel_learn::Model;

use crate::error::Result;
use crate::firmware::with_library;

/// The memory and the instructions that a model takes on a core, as C.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Footprint {
    /// Name of the core.
    pub target: &'static str,
    /// Bytes of flash for tables and code, about.
    pub flash_bytes: u64,
    /// Bytes of the tables.
    pub table_bytes: u64,
    /// Bytes of the workspace.
    pub ram_bytes: u64,
    /// Bytes of the time steps that `push` keeps.
    pub ring_bytes: u64,
    /// Products of weights and values of one prediction.
    pub products: u64,
    /// Instructions of one prediction, about: not cycles. None of MiniRocket and ridge, which were not counted.
    pub instructions: Option<u64>,
    /// A large part with this core, and whether its flash and RAM are enough.
    pub part: Part,
    /// Whether flash, and RAM with the time steps, fit that part; stack is left out.
    pub fits: bool,
}

/// A microcontroller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Part {
    /// Its name.
    pub name: &'static str,
    /// Bytes of flash.
    pub flash_bytes: u64,
    /// Bytes of RAM.
    pub ram_bytes: u64,
}

/// Returns what a model takes on a core, as C, without writing it.
///
/// # Errors
/// A model that has no C, with the reason.
pub fn footprint(model: &Model, core: Core) -> Result<Footprint> {
    with_library(model, None, 0, |library: &Library| {
        library.check_core(core)?;
        let Size { tables, ram, ring, macs, .. } = library.size()?;
        let (flash, part) = (library.flash(core)?, core.part());
        Ok(Footprint {
            target: core.name(),
            part: Part { name: part.name, flash_bytes: part.flash as u64, ram_bytes: part.ram as u64 },
            fits: flash <= part.flash && ram + ring <= part.ram,
            flash_bytes: flash as u64,
            table_bytes: tables as u64,
            ram_bytes: ram as u64,
            ring_bytes: ring as u64,
            products: macs as u64,
            instructions: library.instructions(core)?.map(|count| count as u64),
        })
    })
}

/// Returns the room of a microcontroller with what each row of a run takes, by the model of its first fold, on a Cortex-M4.
///
/// # Errors
/// A model that is missing or damaged.
pub fn room(case: &Case, max_flash: Option<u64>, max_ram: Option<u64>) -> Result<Room> {
    let mut room = Room { max_flash, max_ram, ..Room::default() };
    for network in case.compared() {
        let model = case.first_model(network)?;
        let need = match footprint(&model, Core::M4f) {
            Ok(takes) => Need::Bytes { flash: takes.flash_bytes, ram: takes.ram_bytes + takes.ring_bytes },
            Err(error) => Need::Impossible { reason: reason(&error.to_string(), &model.card().name) },
        };
        room.needs.insert(network.to_string(), need);
    }
    Ok(room)
}

/// Returns the text of an error without the name of the model.
fn reason(error: &str, name: &str) -> String {
    error.strip_prefix(name).and_then(|rest| rest.strip_prefix(": ")).unwrap_or(error).to_string()
}
