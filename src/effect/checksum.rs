//! The checksum of the files that effects read.

/// `TABLES[k][i]` is what byte `i` leaves in the register after `k` more bytes of zeros.
const TABLES: [[u32; 256]; 8] = {
    let mut tables = [[0; 256]; 8];
    let mut i = 0;
    while i < 256 {
        let (mut crc, mut bit) = (i as u32, 0);
        while bit < 8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
            bit += 1;
        }
        tables[0][i] = crc;
        i += 1;
    }
    let mut k = 1;
    while k < 8 {
        let mut i = 0;
        while i < 256 {
            let before = tables[k - 1][i];
            tables[k][i] = before >> 8 ^ tables[0][(before & 0xff) as usize];
            i += 1;
        }
        k += 1;
    }
    tables
};

/// CRC-32 (IEEE 802.3) of all `parts`, one after the other; eight bytes at a time.
pub(super) fn checksum(parts: &[&[u8]]) -> u32 {
    parts.iter().fold(0, |sum, part| longer(sum, part))
}

/// The checksum of what `sum` is the checksum of, and of `bytes` behind it; that of nothing is 0.
pub(super) fn longer(sum: u32, bytes: &[u8]) -> u32 {
    !go_on(!sum, bytes)
}

fn go_on(mut crc: u32, bytes: &[u8]) -> u32 {
    let (eights, rest) = bytes.as_chunks::<8>();
    for eight in eights {
        let word = u64::from_le_bytes(*eight) ^ u64::from(crc);
        crc = (0..8).fold(0, |sum, i| sum ^ TABLES[7 - i][(word >> (8 * i)) as usize & 0xff]);
    }
    rest.iter().fold(crc, |crc, &byte| crc >> 8 ^ TABLES[0][usize::from(crc as u8 ^ byte)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_checksum_of_the_standard() {
        assert_eq!(checksum(&[b"123456789"]), 0xcbf4_3926);
        let text: Vec<u8> = (0..100).collect();
        for cut in 0..100 {
            assert_eq!(checksum(&[&text[..cut], &text[cut..]]), checksum(&[&text]), "cut at {cut}");
        }
    }
}
