use super::*;
use crate::output::testing::scratch;

fn columns() -> Vec<String> {
    ["step", "time", "drag"].map(String::from).to_vec()
}

#[test]
fn every_number_reads_back_with_the_same_bits() {
    let directory = scratch("history-bits");
    let path = directory.join("history.csv");
    let mut seed = 1u64;
    let mut values = vec![0.0, -0.0, 5e-324, f64::MAX, 1.0 / 3.0, 1e-4, 1e15, f64::INFINITY, 431.5];
    for _ in 0..3000 {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        values.extend(Some(f64::from_bits(seed)).filter(|x| x.is_finite()));
    }
    let mut writer = HistoryWriter::create(&path, &columns()).unwrap();
    for (n, &x) in values.iter().enumerate() {
        writer.append(&[n as f64, x, -x]).unwrap();
    }
    let history = History::read(&path).unwrap();
    assert_eq!(history.columns, columns());
    for (n, row) in history.rows.iter().enumerate() {
        assert_eq!(
            row.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
            [(n as f64).to_bits(), values[n].to_bits(), (-values[n]).to_bits()]
        );
    }
    assert_eq!(history.column("time").unwrap().len(), values.len());
    assert_eq!(history.column("lift"), None);
}

#[test]
fn resuming_cuts_later_rows_and_half_written_lines() {
    let directory = scratch("history-resume");
    let path = directory.join("history.csv");
    let mut writer = HistoryWriter::create(&path, &columns()).unwrap();
    (1..=5).for_each(|n| writer.append(&[n as f64, 0.1 * n as f64, 0.5]).unwrap());
    let complete = fs::read(&path).unwrap();
    fs::write(&path, [&complete[..], b"6,0.6"].concat()).unwrap();
    assert_eq!(History::read(&path).unwrap().rows.len(), 5);
    let (mut writer, kept) = HistoryWriter::resume(&path, &columns(), 3, None).unwrap();
    assert_eq!(kept.rows.len(), 3);
    (4..=5).for_each(|n| writer.append(&[n as f64, 0.1 * n as f64, 0.5]).unwrap());
    writer.sync().unwrap();
    assert_eq!(fs::read(&path).unwrap(), complete);
    let (mut writer, kept) = HistoryWriter::resume(&path, &columns(), 0, None).unwrap();
    assert!(kept.rows.is_empty());
    writer.append(&[1.0, 0.1, f64::NAN]).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "step,time,drag\n1,0.1,NaN\n");
}

#[test]
fn whatever_follows_the_last_row_needed_is_cut_off() {
    let directory = scratch("history-garbage");
    let path = directory.join("history.csv");
    let good = "step,time,drag\n1,0.1,2\n2,0.2,2\n";
    for garbage in [&b"\xff\xfe\x00\n\x80"[..], b"3,oops,2\n", b"\n\n", b"3,0.3", b"2,0.2,2\n3,0.3,2\n"] {
        fs::write(&path, [good.as_bytes(), garbage].concat()).unwrap();
        let (writer, kept) = HistoryWriter::resume(&path, &columns(), 2, None).unwrap();
        assert_eq!((kept.rows.len(), fs::read_to_string(&path).unwrap()), (2, good.to_string()));
        writer.verify().unwrap();
    }
    // Damage before it.
    fs::write(&path, "step,time,drag\n1,0.1,\n2,0.2,2\n").unwrap();
    assert!(HistoryWriter::resume(&path, &columns(), 2, None).is_err());
    assert!(HistoryWriter::resume(&path, &columns(), 0, None).is_ok());
}

#[test]
fn the_row_of_a_checkpoint_stands_in_for_one_that_could_not_be_written() {
    let directory = scratch("history-row");
    let path = directory.join("history.csv");
    fs::write(&path, "step,time,drag\n1,0.1,2\n2,0.").unwrap();
    for other in [None, Some("3,0.3,2"), Some("2,0.2")] {
        assert!(HistoryWriter::resume(&path, &columns(), 2, other).is_err());
    }
    let (_, kept) = HistoryWriter::resume(&path, &columns(), 2, Some("2,0.2,NaN")).unwrap();
    assert_eq!((kept.rows.len(), kept.rows[1][1]), (2, 0.2));
    assert_eq!(fs::read_to_string(&path).unwrap(), "step,time,drag\n1,0.1,2\n2,0.2,NaN\n");
    assert!(HistoryWriter::resume(&path, &columns(), 4, Some("4,0.4,1")).is_err());
}

#[cfg(unix)]
#[test]
fn a_file_that_is_gone_or_changed_is_noticed() {
    let directory = scratch("history-gone");
    let path = directory.join("history.csv");
    let mut writer = HistoryWriter::create(&path, &columns()).unwrap();
    writer.append(&[1.0, 2.0, 3.0]).unwrap();
    writer.verify().unwrap();
    let copy = fs::read(&path).unwrap();
    fs::remove_file(&path).unwrap();
    assert!(writer.verify().unwrap_err().to_string().contains("history.csv: was removed"));
    fs::write(&path, copy).unwrap();
    assert!(writer.verify().is_err(), "the same bytes in another file");
    let writer = HistoryWriter::create(&path, &columns()).unwrap();
    fs::write(&path, "").unwrap();
    assert!(writer.verify().is_err(), "another length");
}

#[cfg(unix)]
#[test]
fn rows_are_read_back_between_two_and_without_a_name() {
    let directory = scratch("history-back");
    let path = directory.join("history.csv");
    let mut writer = HistoryWriter::create(&path, &columns()).unwrap();
    let steps = |writer: &HistoryWriter| {
        let mut steps = vec![];
        writer.for_each_row(|row| steps.push(row[0])).unwrap();
        steps
    };
    writer.append(&[1.0, 0.1, f64::NAN]).unwrap();
    assert_eq!(steps(&writer), [1.0]);
    writer.append(&[2.0, 0.2, 3.0]).unwrap();
    assert_eq!(History::read(&path).unwrap().rows[1], [2.0, 0.2, 3.0], "at the end, not where was read");
    let (mut writer, _) = HistoryWriter::resume(&path, &columns(), 2, None).unwrap();
    fs::remove_file(&path).unwrap();
    writer.append(&[3.0, 0.3, 4.0]).unwrap();
    assert_eq!(steps(&writer), [1.0, 2.0, 3.0]);
}

#[test]
fn mismatches_are_named() {
    let directory = scratch("history-errors");
    let path = directory.join("history.csv");
    fs::write(&path, "step,time,drag\n1,0.1,2\n2,oops,2\n").unwrap();
    assert!(History::read(&path).unwrap_err().to_string().contains("line 3: expected 3 numbers"));
    fs::write(&path, "step,time,drag\n1,0.1,2\n").unwrap();
    let later = HistoryWriter::resume(&path, &columns(), 7, None).unwrap_err().to_string();
    assert!(later.contains("ends at step 1, before step 7"), "{later}");
    assert!(HistoryWriter::resume(&path, &columns()[..2], 1, None).is_err());
    assert!(History::read(path.with_extension("missing")).is_err());
}
