//! Rows of many figures packed into one column; long texts.

pub(super) mod history_row;
pub(super) mod text;
pub(super) mod verdicts;

/// Over packed bytes and the number of what they belong to, so that bytes that strayed to another are found out.
fn checksum<const N: usize>(number: [u8; N], bytes: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&number);
    hasher.update(bytes);
    hasher.finalize()
}

/// Takes fields off the front of packed bytes, little-endian; none where too few are left.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*head)
    }

    fn figures<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut figures = [0.0; N];
        for figure in &mut figures {
            *figure = f64::from_le_bytes(self.take()?);
        }
        Some(figures)
    }
}
