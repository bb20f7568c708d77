//! Array files of `NumPy`.

use std::io;

use npyz::{NpyFile, Order, TypeChar, WriterBuilder};

use super::{Image, checked_size};

/// Header text longer than this is not that of a picture (`NumPy` pads it to a few dozen bytes).
const MAX_HEADER: usize = 4096;
/// More digits than this in the header would overflow the product of the dimensions, which npyz leaves unchecked.
const MAX_DIGITS: usize = 18;
/// Deeper brackets than a shape or a record type needs; npyz parses them recursively.
const MAX_DEPTH: usize = 4;

/// Decodes a picture; the error is the part of a sentence that follows the file's name.
pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    check_header(bytes)?;
    let file = NpyFile::new(bytes).map_err(|error| format!("not a readable .npy file: {error}"))?;
    let header = file.header().clone();

    let wrong_shape = || format!("shape {:?}; a picture is (H, W, 3), or (H, W) for grey", header.shape());
    let (height, width, channels) = match *header.shape() {
        [height, width, channels @ (1 | 3)] => (height, width, channels),
        [height, width] => (height, width, 1),
        _ => return Err(wrong_shape()),
    };
    let (width, height) = checked_size(width, height)?;

    let size = match header.dtype() {
        npyz::DType::Plain(scalar) if scalar.type_char() == TypeChar::Float => scalar.num_bytes(),
        _ => None,
    };
    let needed = size.and_then(|size| usize::try_from(header.len()).ok()?.checked_mul(size));
    let held = file.into_inner();
    // the data must be there before anything of its size is allocated
    if needed.is_some_and(|needed| held.len() < needed) {
        return Err(format!(
            "truncated: {} bytes of data, {} expected",
            held.len(),
            needed.unwrap_or_default()
        ));
    }
    let file = NpyFile::with_header(header.clone(), held);
    let values: Vec<f32> = match size {
        Some(4) => file.into_vec::<f32>(),
        Some(8) => file.into_vec::<f64>().map(|values| values.into_iter().map(|v| v as f32).collect()),
        _ => return Err(format!("holds {}; a picture is float32 or float64", header.dtype().descr())),
    }
    .map_err(|error| format!("cannot be read: {error}"))?;

    let (columns, rows, depth) = (width as usize, height as usize, channels as usize);
    let index = |row: usize, column: usize, channel: usize| match header.order() {
        Order::C => (row * columns + column) * depth + channel,
        Order::Fortran => row + rows * (column + columns * channel),
    };
    let pixels = (0..rows)
        .flat_map(|row| (0..columns).map(move |column| (row, column)))
        .map(|(row, column)| [0, 1, 2].map(|channel| values[index(row, column, channel.min(depth - 1))]))
        .collect();
    Ok(Image { width, height, pixels })
}

/// Refuses headers that the parser behind would overflow, recurse or allocate on.
fn check_header(bytes: &[u8]) -> Result<(), String> {
    let text = match bytes {
        [0x93, b'N', b'U', b'M', b'P', b'Y', 1, 0, a, b, rest @ ..] => {
            rest.get(..usize::from(u16::from_le_bytes([*a, *b])))
        }
        [0x93, b'N', b'U', b'M', b'P', b'Y', 2 | 3, 0, a, b, 0, 0, rest @ ..] => {
            rest.get(..usize::from(u16::from_le_bytes([*a, *b])))
        }
        _ => return Err("not a .npy file".to_owned()),
    };
    let text = text.ok_or("truncated inside the header")?;
    let mut depth = 0_usize;
    let mut deepest = 0;
    for byte in text {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        deepest = deepest.max(depth);
    }
    let digits = text.iter().filter(|byte| byte.is_ascii_digit()).count();
    if text.len() > MAX_HEADER || deepest > MAX_DEPTH || digits > MAX_DIGITS {
        return Err("its header is not that of a picture".to_owned());
    }
    Ok(())
}

/// Little-endian float32, shape (H, W, 3), C order.
pub(super) fn encode(image: &Image) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(128 + 12 * image.pixels.len());
    let little_endian_f32 = "<f4".parse().map_err(io::Error::other)?;
    let mut writer = npyz::WriteOptions::new()
        .dtype(npyz::DType::Plain(little_endian_f32))
        .shape(&[u64::from(image.height), u64::from(image.width), 3])
        .writer(&mut bytes)
        .begin_nd()?;
    writer.extend(image.pixels.iter().flatten().copied())?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(descr: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
        let order = if fortran { "True" } else { "False" };
        let text = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend(u16::try_from(text.len()).unwrap().to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes.extend(data);
        bytes
    }

    /// 2 rows, 1 column: (0, 1, 2), (3, 4, 5).
    fn counted() -> Image {
        Image { width: 1, height: 2, pixels: vec![[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]] }
    }

    #[test]
    fn every_byte_order_and_width_reads_the_same() {
        let c_order = [0, 1, 2, 3, 4, 5].map(f64::from);
        let little: Vec<u8> = c_order.iter().flat_map(|v| (*v as f32).to_le_bytes()).collect();
        let big: Vec<u8> = c_order.iter().flat_map(|v| (*v as f32).to_be_bytes()).collect();
        let wide: Vec<u8> = c_order.iter().flat_map(|v| v.to_le_bytes()).collect();
        let fortran: Vec<u8> = [0, 3, 1, 4, 2, 5].iter().flat_map(|v| f64::from(*v).to_be_bytes()).collect();
        assert_eq!(decode(&npy("<f4", false, "(2, 1, 3)", &little)).unwrap(), counted());
        assert_eq!(decode(&npy(">f4", false, "(2, 1, 3)", &big)).unwrap(), counted());
        assert_eq!(decode(&npy("<f8", false, "(2, 1, 3)", &wide)).unwrap(), counted());
        assert_eq!(decode(&npy(">f8", true, "(2, 1, 3)", &fortran)).unwrap(), counted());
        let grey = decode(&npy("<f4", false, "(2, 3)", &little)).unwrap();
        assert_eq!((grey.width, grey.height, grey.pixels[4]), (3, 2, [4.0; 3]));
    }

    #[test]
    fn encoding_is_little_endian_float32_in_c_order() {
        let bytes = encode(&counted()).unwrap();
        let text = String::from_utf8_lossy(&bytes[..128]);
        assert!(text.contains("'<f4'") && text.contains("False") && text.contains("(2, 1, 3, )"), "{text}");
        assert_eq!(bytes[bytes.len() - 4..], 5.0_f32.to_le_bytes());
        assert_eq!(decode(&bytes).unwrap(), counted());
    }

    #[test]
    fn nonsense_is_refused_in_words() {
        let data = [0_u8; 24];
        let deep = "(".repeat(3000);
        let cases = [
            ("<f4", "(4000000, 4000000, 3)", "pixels"),
            ("<f4", "(4000000000, 4000000000, 3)", "header"),
            ("<f4", "(9000, 9000, 3)", "truncated"),
            ("<f4", "(2, 1, 3000000)", "shape"),
            ("<f4", "(0, 4, 3)", "pixels"),
            ("<f4", "(24,)", "shape"),
            ("<f4", "()", "shape"),
            ("<i4", "(2, 1, 3)", "float32"),
            ("|O", "(2, 1, 3)", "float32"),
            ("<f4", &deep, "header"),
            ("<f4", "(-1, 2, 3)", "not a readable"),
        ];
        for (descr, shape, word) in cases {
            let reason = decode(&npy(descr, false, shape, &data)).unwrap_err();
            assert!(reason.contains(word), "{descr} {shape}: {reason}");
        }
        assert!(decode(b"").is_err());
        assert!(decode(&[0x93, b'N', b'U', b'M', b'P', b'Y', 2, 0, 255, 255, 255, 255]).is_err());
    }

    #[test]
    fn no_prefix_of_a_file_reads_or_panics() {
        let whole = encode(&counted()).unwrap();
        for length in 0..whole.len() {
            assert!(decode(&whole[..length]).is_err(), "{length} of {} bytes", whole.len());
        }
    }

    #[test]
    fn no_changed_byte_panics() {
        let whole = encode(&counted()).unwrap();
        for position in 0..whole.len() {
            for value in [0, 1, b'(', b'9', 0x7f, 0xff] {
                let mut bytes = whole.clone();
                bytes[position] = value;
                // either reading is right as long as it comes back
                let _ = decode(&bytes);
            }
        }
    }
}
