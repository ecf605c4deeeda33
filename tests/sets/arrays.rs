//! Writers of named arrays: NumPy archives, MATLAB files of version 5, and HDF5 of the oldest kind.

use taxel::data::Npz;

/// The values of an array, row-major.
pub enum Values {
    Floats(Vec<f32>),
    Ints(Vec<i64>),
    /// Only for a NumPy archive.
    Bytes(Vec<u8>),
}

/// An array with its name.
pub struct Array {
    pub name: &'static str,
    pub shape: Vec<usize>,
    pub values: Values,
}

impl Array {
    pub fn floats(name: &'static str, shape: &[usize], values: Vec<f32>) -> Self {
        Self { name, shape: shape.to_vec(), values: Values::Floats(values) }
    }

    pub fn ints(name: &'static str, values: impl IntoIterator<Item = i64>) -> Self {
        let values: Vec<i64> = values.into_iter().collect();
        Self { name, shape: vec![values.len()], values: Values::Ints(values) }
    }
}

/// Returns the bytes of a file of arrays by its ending.
pub fn archive(ending: &str, arrays: &[Array]) -> Vec<u8> {
    match ending {
        "npz" => npz(arrays),
        "mat" => mat(arrays),
        "h5" | "hdf5" => hdf5(arrays),
        other => panic!("no writer of .{other}"),
    }
}

fn npz(arrays: &[Array]) -> Vec<u8> {
    let mut npz = Npz::default();
    for Array { name, shape, values } in arrays {
        match values {
            Values::Floats(values) => npz.add(name, shape, values),
            Values::Ints(values) => npz.add(name, shape, values),
            Values::Bytes(values) => npz.add(name, shape, values),
        }
        .unwrap();
    }
    npz.finish().unwrap()
}

/// Writes doubles and singles, uncompressed; MATLAB lets the first axis run fastest.
fn mat(arrays: &[Array]) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0, 1, b'I', b'M']);
    for Array { name, shape, values } in arrays {
        // Every array of MATLAB has two axes.
        let shape = if shape.len() == 1 { [shape[0], 1].to_vec() } else { shape.clone() };
        let (class, kind, data): (u8, u32, Vec<u8>) = match values {
            Values::Floats(values) => {
                (7, 7, turned(&shape, values).into_iter().flat_map(f32::to_le_bytes).collect())
            }
            Values::Ints(values) => {
                (6, 9, turned(&shape, values).into_iter().flat_map(|v| (v as f64).to_le_bytes()).collect())
            }
            Values::Bytes(_) => panic!("no bytes in a MATLAB file"),
        };
        let axes: Vec<u8> = shape.iter().flat_map(|axis| (*axis as i32).to_le_bytes()).collect();
        let flags = [u32::from(class).to_le_bytes(), [0; 4]].concat();
        let parts = [part(6, &flags), part(5, &axes), part(1, name.as_bytes()), part(kind, &data)].concat();
        bytes.extend(part(14, &parts));
    }
    bytes
}

/// A data element: its type, its size, its bytes, filled up to eight.
fn part(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

/// Brings row-major values into the order in which the first axis runs fastest.
fn turned<T: Copy>(shape: &[usize], values: &[T]) -> Vec<T> {
    let mut index = vec![0; shape.len()];
    let mut turned = Vec::with_capacity(values.len());
    for _ in 0..values.len() {
        let flat = index.iter().zip(shape).fold(0, |flat, (at, axis)| flat * axis + at);
        turned.push(values[flat]);
        for (at, axis) in index.iter_mut().zip(shape) {
            *at += 1;
            if *at < *axis {
                break;
            }
            *at = 0;
        }
    }
    turned
}

/// The address that stands for none.
const NONE: [u8; 8] = [0xFF; 8];

/// Writes contiguous data sets in the root group, with the structures of HDF5 1.0: superblock 0, a group of one leaf.
fn hdf5(arrays: &[Array]) -> Vec<u8> {
    let mut sorted: Vec<&Array> = arrays.iter().collect();
    sorted.sort_by_key(|array| array.name);
    let (header, tree, heap, names, leaf) = (96u64, 136u64, 680u64, 712u64, 968u64);
    let mut place = leaf + 8 + 40 * 8;
    // Names, each filled up to eight bytes, after an empty one.
    let mut texts = vec![0u8; 8];
    let mut entries = vec![];
    let mut objects = vec![];
    for array in &sorted {
        let name = texts.len() as u64;
        texts.extend(array.name.as_bytes());
        texts.resize((texts.len() + 1).next_multiple_of(8), 0);
        let data: Vec<u8> = match &array.values {
            Values::Floats(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            Values::Ints(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            Values::Bytes(_) => panic!("no bytes in HDF5"),
        };
        let mut object = object_of(array, place, data.len());
        object.extend(data);
        object.resize(object.len().next_multiple_of(8), 0);
        entries.extend([name.to_le_bytes(), place.to_le_bytes(), [0; 8], [0; 8], [0; 8]].concat());
        place += object.len() as u64;
        objects.extend(object);
    }
    let last = texts.len() as u64;
    assert!(arrays.len() <= 8 && last <= 256, "one leaf and a small heap");
    texts.resize(256, 0);

    let mut bytes = b"\x89HDF\r\n\x1a\n".to_vec();
    bytes.extend([0, 0, 0, 0, 0, 8, 8, 0, 4, 0, 16, 0, 0, 0, 0, 0]);
    bytes.extend([[0; 8], NONE, place.to_le_bytes(), NONE, [0; 8], header.to_le_bytes()].concat());
    bytes.extend([1, 0, 0, 0, 0, 0, 0, 0]);
    bytes.extend([tree.to_le_bytes(), heap.to_le_bytes()].concat());
    let table = message(0x11, &[tree.to_le_bytes(), heap.to_le_bytes()].concat());
    bytes.extend(object_header(&[table]));
    bytes.resize(tree as usize, 0);
    bytes.extend([&b"TREE\0\0\x01\0"[..], &NONE, &NONE].concat());
    let greatest = (entries.len() as u64 / 40).checked_sub(1).map_or([0; 8], |at| {
        let at = 40 * at as usize;
        <[u8; 8]>::try_from(&entries[at..at + 8]).unwrap()
    });
    bytes.extend([[0; 8], leaf.to_le_bytes(), greatest].concat());
    bytes.resize(heap as usize, 0);
    bytes.extend(
        [&b"HEAP\0\0\0\0"[..], &256u64.to_le_bytes(), &1u64.to_le_bytes(), &names.to_le_bytes()].concat(),
    );
    bytes.extend(texts);
    bytes.extend([&b"SNOD\x01\0"[..], &(sorted.len() as u16).to_le_bytes()].concat());
    bytes.extend(entries);
    bytes.resize((leaf + 8 + 40 * 8) as usize, 0);
    bytes.extend(objects);
    bytes
}

fn message(kind: u16, data: &[u8]) -> Vec<u8> {
    let size = data.len().next_multiple_of(8);
    let mut bytes = [kind.to_le_bytes(), (size as u16).to_le_bytes(), [0; 2], [0; 2]].concat();
    bytes.extend(data);
    bytes.resize(8 + size, 0);
    bytes
}

fn object_header(messages: &[Vec<u8>]) -> Vec<u8> {
    let size: usize = messages.iter().map(Vec::len).sum();
    let mut bytes = vec![1, 0];
    bytes.extend((messages.len() as u16).to_le_bytes());
    bytes.extend(1u32.to_le_bytes());
    bytes.extend((size as u32).to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(messages.concat());
    bytes
}

/// Returns the header of a data set whose values follow it.
fn object_of(array: &Array, place: u64, size: usize) -> Vec<u8> {
    let mut space = vec![1, array.shape.len() as u8, 0, 0, 0, 0, 0, 0];
    space.extend(array.shape.iter().flat_map(|axis| (*axis as u64).to_le_bytes()));
    let kind = match array.values {
        Values::Floats(_) => {
            [&[0x11, 0x20, 31, 0, 4, 0, 0, 0, 0, 0, 32, 0, 23, 8, 0, 23][..], &127u32.to_le_bytes()].concat()
        }
        _ => vec![0x10, 8, 0, 0, 8, 0, 0, 0, 0, 0, 64, 0],
    };
    let layout =
        |at: u64| message(8, &[&[3, 1][..], &at.to_le_bytes(), &(size as u64).to_le_bytes()].concat());
    let header = |at: u64| object_header(&[message(1, &space), message(3, &kind), layout(at)]);
    header(place + header(0).len() as u64)
}
