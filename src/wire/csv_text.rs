//! A table as text (RFC 4180).

/// The lines below a header, each with a cell for every name in it.
pub fn csv_text<T: AsRef<[u8]>, const N: usize>(header: &str, lines: impl IntoIterator<Item = [T; N]>) -> String {
    let mut writer = csv::Writer::from_writer(format!("{header}\n").into_bytes());
    let memory = "lines have one length and memory takes them";
    lines.into_iter().for_each(|line| writer.write_record(line).expect(memory));
    String::from_utf8_lossy(&writer.into_inner().expect(memory)).into_owned()
}
