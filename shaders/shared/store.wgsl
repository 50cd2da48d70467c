// Spectra on their way out of a common transform to where they are kept. Mirrors `Store` of src/filter/gpu/layout.rs.

struct Store {
    // Of the canvas; the transform is stored column by column.
    width: u32,
    height: u32,
    // The columns to be stored: their first, and how many.
    begin: u32,
    columns: u32,
    // Spectra stored for each column, and where up to two belong among them; the second may be NOTHING.
    planes: u32,
    first: u32,
    second: u32,
    padding: u32,
}

const NOTHING: u32 = 0xffffffffu;

@group(0) @binding(0) var<uniform> store: Store;
@group(0) @binding(1) var<storage, read> pair: array<vec2f>;
@group(0) @binding(2) var<storage, read_write> spectra: array<vec2f>;

// The `at`th frequency to be stored: where it is, the common transform there and at the opposite frequency.
struct Stored {
    column: u32,
    kx: u32,
    ky: u32,
    z: vec2f,
    opposite: vec2f,
}

fn stored(at: u32) -> Stored {
    let column = at / store.height;
    let kx = store.begin + column;
    let ky = at % store.height;
    let back = ((store.width - kx) % store.width) * store.height + (store.height - ky) % store.height;
    return Stored(column, kx, ky, pair[kx * store.height + ky], pair[back]);
}

// Where spectrum `plane` has that frequency.
fn kept(here: Stored, plane: u32) -> u32 {
    return (here.column * store.planes + plane) * store.height + here.ky;
}
