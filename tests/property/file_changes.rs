//! Changes of the bytes of a file.

use proptest::prelude::*;

/// A change of a file.
#[derive(Clone, Debug)]
pub enum Change {
    /// A byte becomes another.
    Byte(prop::sample::Index, u8),
    /// Bytes are taken out.
    Cut(prop::sample::Index, prop::sample::Index),
    /// Bytes are there twice.
    Repeat(prop::sample::Index, prop::sample::Index),
    /// Something is put in.
    Insert(prop::sample::Index, Vec<u8>),
    /// The file ends early.
    End(prop::sample::Index),
}

/// Any change.
pub fn change() -> impl Strategy<Value = Change> {
    let place = any::<prop::sample::Index>;
    let words: Vec<&[u8]> = vec![
        b"-1",
        b"0",
        b"1e400",
        b"nan",
        b"inf",
        b"18446744073709551615",
        b"9999999999",
        b"\n",
        b",",
        b"\0",
        b"$Nodes\n",
        b"$EndElements\n",
        b"*NODE\n",
        b"*NSET, NSET=x, GENERATE\n1, 4000000000, 1\n",
        b"*INCLUDE, INPUT=x\n",
        b"vertex ",
        b"endsolid\nsolid\n",
        b"\xff\xff\xff\xff\xff\xff\xff\x7f",
        b"\xff\xff\xff\xff\xff\xff\xff\xff",
    ];
    let words: Vec<Vec<u8>> = words.into_iter().map(<[u8]>::to_vec).collect();
    let inserted = prop_oneof![prop::sample::select(words), prop::collection::vec(any::<u8>(), 0..12)];
    prop_oneof![
        3 => (place(), any::<u8>()).prop_map(|(at, byte)| Change::Byte(at, byte)),
        1 => (place(), place()).prop_map(|(from, to)| Change::Cut(from, to)),
        1 => (place(), place()).prop_map(|(from, to)| Change::Repeat(from, to)),
        2 => (place(), inserted).prop_map(|(at, bytes)| Change::Insert(at, bytes)),
        1 => place().prop_map(Change::End),
    ]
}

/// Changes a file.
pub fn apply(bytes: &mut Vec<u8>, change: Change) {
    if bytes.is_empty() {
        return;
    }
    let range = |from: prop::sample::Index, to: prop::sample::Index, length: usize| {
        let (a, b) = (from.index(length), to.index(length));
        a.min(b)..a.max(b)
    };
    match change {
        Change::Byte(at, byte) => {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        Change::Cut(from, to) => drop(bytes.drain(range(from, to, bytes.len()))),
        Change::Repeat(from, to) => {
            let range = range(from, to, bytes.len());
            let again = bytes[range.clone()].to_vec();
            bytes.splice(range.end..range.end, again);
        }
        Change::Insert(at, inserted) => {
            let at = at.index(bytes.len());
            bytes.splice(at..at, inserted);
        }
        Change::End(at) => bytes.truncate(at.index(bytes.len())),
    }
}
