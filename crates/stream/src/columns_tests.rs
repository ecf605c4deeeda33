//! Lines of numbers and names as time steps.

#![allow(clippy::unwrap_used, clippy::panic)]

use taxel_data::{Clock, Layout, SampleSpec, TableOptions};

use crate::columns::LineColumns;
use crate::fault::Fault;
use crate::time_column::Time;

fn series(channels: usize) -> SampleSpec {
    SampleSpec::new(Layout::Series, &[channels, 10])
}

fn plain(spec: &SampleSpec) -> LineColumns {
    LineColumns::new(spec, None, None)
}

type Read = Option<(Vec<f32>, Option<f64>)>;

fn read(columns: &mut LineColumns, line: &str) -> Result<Read, Fault> {
    let mut values = vec![];
    Ok(columns.read(line, &mut values)?.map(|stamp| (values, stamp)))
}

fn good(columns: &mut LineColumns, line: &str) -> (Vec<f32>, Option<f64>) {
    read(columns, line).unwrap_or_else(|e| panic!("{line:?}: {e:?}")).unwrap_or_else(|| panic!("{line:?}"))
}

#[test]
fn numbers_are_read_however_they_are_parted() {
    for line in
        ["1,2.5", " 1 , 2.5\r", "1;2.5", "1\t2.5", "1  2.5", "[1, 2.5]", "[[1],[2.5]]", "\u{feff}1,25e-1"]
    {
        assert_eq!(good(&mut plain(&series(2)), line), (vec![1.0, 2.5], None), "{line:?}");
    }
    assert_eq!(read(&mut plain(&series(2)), "  \r").unwrap(), None);
}

#[test]
fn time_is_a_column_by_number_name_or_header() {
    let stamped = |time: &str, clock| LineColumns::new(&series(2), Some(time.parse().unwrap()), clock);
    let want = (vec![1.0, 2.0], Some(0.5));
    assert_eq!(good(&mut stamped("1", None), "0.5,1,2"), want);
    assert_eq!(good(&mut stamped("3", Some(Clock::Milliseconds)), "1,2,500"), want);
    let mut header = plain(&series(2));
    assert_eq!(read(&mut header, "a,time_ms,b").unwrap(), None);
    assert_eq!(good(&mut header, "1,500,2"), want);
    assert_eq!(read(&mut header, "a,time_ms,b").unwrap(), None, "a device that starts again");
    let mut named = stamped("stamp", None);
    read(&mut named, "stamp;a;b").unwrap();
    assert_eq!(good(&mut named, "0.5;1;2"), want);
    for line in
        [r#"{"t":0.5,"a":1,"b":2}"#, r#"{"a":1,"b":2,"time":0.5,"ok":true}"#, r#"{"t":0.5,"x":[1,2]}"#]
    {
        assert_eq!(good(&mut plain(&series(2)), line), want, "{line}");
    }
    assert!("0".parse::<Time>().is_err());
    for (time, line) in [("nosuch", "1,2"), ("nosuch", r#"{"t":0.5,"a":1,"b":2}"#), ("4", "1,2")] {
        let refused = read(&mut stamped(time, None), line).unwrap_err();
        let (Fault::Columns(why) | Fault::Names(why)) = &refused else { panic!("{refused:?}") };
        assert!(why.contains("--time"), "{why}");
    }
    // Nanoseconds since 1970 keep their microseconds.
    let mut long = stamped("1", Some(Clock::Nanoseconds));
    let (_, stamp) = good(&mut long, "1795363200123456789,1,2");
    assert!((stamp.unwrap() - 1_795_363_200.123_456_7).abs() < 1e-6);
}

#[test]
fn channels_are_found_by_name_and_taken_of_more() {
    let table = TableOptions { columns: vec!["thumb".into(), "index".into()], ..TableOptions::default() };
    let mut by_name = plain(&SampleSpec { table: Some(table), ..series(2) });
    read(&mut by_name, "index,id,thumb").unwrap();
    assert_eq!(good(&mut by_name, "1,left,2").0, [2.0, 1.0]);
    assert_eq!(good(&mut by_name, r#"{"thumb":3,"id":"x","index":4}"#).0, [3.0, 4.0]);
    let mut objects = plain(&series(2));
    assert_eq!(good(&mut objects, r#"{"a":1,"b":2}"#).0, [1.0, 2.0]);
    assert_eq!(good(&mut objects, r#"{"b":2,"a":1}"#).0, [1.0, 2.0], "the first object says the order");
    let mut some = plain(&SampleSpec { channels: Some(vec![2, 0]), ..series(2) });
    assert_eq!(good(&mut some, "5,6,7,8").0, [7.0, 5.0]);
    let fingers = SampleSpec::new(Layout::Fingers, &[1, 2, 10]);
    let mut second = plain(&SampleSpec { channels: Some(vec![1]), ..fingers });
    assert_eq!(good(&mut second, "1,2,3,4").0, [3.0, 4.0]);
}

#[test]
fn channels_that_nobody_knows_are_those_of_the_first_line() {
    for (header, line, names) in [
        ("thumb,time_ms,id,index", "1,500,7,2", &["thumb", "index"][..]),
        ("", r#"{"t":0.5,"a":1,"b":2}"#, &["a", "b"]),
        ("a banner of three and more", "1,2", &[]),
    ] {
        let (mut columns, channels) = LineColumns::any(None, None);
        assert_eq!(read(&mut columns, header).unwrap(), None, "{header}");
        assert_eq!(channels.names(), None);
        assert_eq!(good(&mut columns, line).0, [1.0, 2.0], "{header}");
        assert_eq!(channels.names().unwrap(), names, "{header}");
        assert!(matches!(read(&mut columns, "1,2,3,4,5"), Err(Fault::Columns(_))), "{header}");
    }
    let (mut stamps, _) = LineColumns::any(Some(Time::At(0)), None);
    assert!(matches!(read(&mut stamps, "0.5"), Err(Fault::Columns(_))));
}

#[test]
fn names_of_the_model_are_found_or_refused() {
    let names = ["thumb", "index"].map(String::from).to_vec();
    let known = || plain(&SampleSpec { channel_names: names.clone(), ..series(2) });
    for header in ["index,id,thumb", ",index,ring,thumb", "time_ms,index,thumb"] {
        let mut columns = known();
        assert_eq!(read(&mut columns, header).unwrap(), None, "{header}");
        let line = header
            .replace("thumb", "1")
            .replace("index", "2")
            .replace(|c: char| c.is_alphabetic() || c == '_', "");
        let line = line
            .split(',')
            .map(|cell| if cell.is_empty() { "9" } else { cell })
            .collect::<Vec<_>>()
            .join(",");
        assert_eq!(good(&mut columns, &line).0, [1.0, 2.0], "{header}: {line}");
    }
    assert_eq!(good(&mut known(), r#"{"x":[7,8],"index":2,"thumb":1}"#).0, [1.0, 2.0]);
    assert_eq!(good(&mut known(), "1,2").0, [1.0, 2.0], "lines without names");
    let lists = SampleSpec { channel_names: vec!["x[1]".into(), "a".into()], ..series(2) };
    assert_eq!(good(&mut plain(&lists), r#"{"a":3,"x":[7,8]}"#).0, [8.0, 3.0]);
    for (header, line, part) in [
        ("thumb,ring", "1,2", "no channel \"index\", which the model reads; there are thumb, ring"),
        ("thumb,index,thumb", "1,2,3", "two columns are named \"thumb\""),
    ] {
        let mut columns = known();
        read(&mut columns, header).unwrap();
        assert!(matches!(read(&mut columns, line), Err(Fault::Names(why)) if why.contains(part)), "{header}");
    }
}

#[test]
fn indices_are_no_channels_and_dates_are_stamps() {
    for header in ["Unnamed: 0,a,t,b", ",a,t,b", "frame_index,a,t,b"] {
        let mut columns = plain(&series(2));
        read(&mut columns, header).unwrap();
        assert_eq!(good(&mut columns, "7,1,0.5,2"), (vec![1.0, 2.0], Some(0.5)), "{header}");
        assert_eq!(good(&mut columns, "7,1,1970-01-01T00:00:02.5Z,2"), (vec![1.0, 2.0], Some(2.5)));
    }
    let object = r#"{"time_ms":"1970-01-01 00:00:02.5","a":1,"b":2}"#;
    assert_eq!(good(&mut plain(&series(2)), object), (vec![1.0, 2.0], Some(2.5)));
    let mut numbered = plain(&series(3));
    assert_eq!(read(&mut numbered, "0,1,2").unwrap(), None);
    assert_eq!(good(&mut numbered, "5,6,7").0, [5.0, 6.0, 7.0]);
}

#[test]
fn a_column_of_time_that_is_not_there_is_refused() {
    let named = || LineColumns::new(&series(2), Some(Time::Named("nosuch".into())), None);
    for lines in [&["t,a,b", "0,1,2"][..], &["1,2"], &[r#"{"t":0,"a":1,"b":2}"#]] {
        let mut columns = named();
        let last = lines.iter().map(|line| read(&mut columns, line)).last().unwrap();
        assert!(matches!(last, Err(Fault::Names(why)) if why.contains("nosuch")), "{lines:?}");
    }
    let mut far = LineColumns::new(&series(2), Some(Time::At(8)), None);
    assert!(
        matches!(read(&mut far, "1,2"), Err(Fault::Columns(why)) if why.contains("--time names column 9"))
    );
}

#[test]
fn what_is_no_reading_says_why() {
    let refused = |lines: &[&str]| {
        let mut columns = plain(&series(2));
        let mut last = Ok(None);
        lines.iter().for_each(|line| last = read(&mut columns, line));
        last.unwrap_err()
    };
    let malformed = |part: &str, lines: &[&str]| match refused(lines) {
        Fault::Malformed(why) => assert!(why.contains(part), "{why}"),
        other => panic!("{lines:?}: {other:?}"),
    };
    malformed("column 2: \"x\" is no number", &["1,2", "1,x"]);
    malformed("column 1: \"\" is no number", &["1,2", ",2"]);
    malformed("\"b\" is no number", &["a,b", "1,b"]);
    malformed("JSON", &["[1,2"]);
    malformed("\"b\"", &[r#"{"a":1,"b":2}"#, r#"{"a":1}"#]);
    malformed("column 2", &["1,2", "1,2;3"]);
    let columns = |part: &str, lines: &[&str]| match refused(lines) {
        Fault::Columns(why) => assert!(why.contains(part), "{why}"),
        other => panic!("{lines:?}: {other:?}"),
    };
    columns(
        "it has 3 numbers, a reading of the model has 2; if the first is a time stamp, say --time 1",
        &["1,2,3"],
    );
    columns("1 numbers", &["1,2", "5"]);
    assert!(matches!(refused(&["1,2", "1,NaN"]), Fault::NotFinite(why) if why.contains("column 2")));
    assert!(matches!(refused(&["t,a,b", "inf,1,2"]), Fault::NotFinite(_)));
}

#[test]
fn a_header_that_changes_ends_the_stream() {
    let names_of = |spec: SampleSpec, header: &str, line: &str| {
        let mut columns = plain(&spec);
        assert_eq!(read(&mut columns, header).unwrap(), None, "{header}");
        good(&mut columns, line);
        columns
    };
    for (header, other) in [
        ("thumb,index", "index,thumb"),
        ("thumb,index", "thumb,index,ring"),
        ("thumb,index", "x,y"),
        ("thumb,index", "Force [N],Torque [Nm]"),
        ("channel 1,channel 2", "channel 2,channel 1"),
    ] {
        let mut columns = names_of(series(2), header, "1,2");
        let Err(Fault::Names(why)) = read(&mut columns, other) else { panic!("{header} {other}") };
        let parts = [header, other].map(|names| names.replace(',', ", "));
        assert!(why.contains(&format!("expected {}, as before, and found {}", parts[0], parts[1])), "{why}");
    }
    // What a device says beside its readings, and the same header again with its units.
    for other in [
        "OVERFLOW",
        "OL,OL",
        "sensor 3 lost",
        "error: no power, please wait",
        "thumb lost",
        "thumb lost its cable, see the log",
    ] {
        let mut columns = names_of(series(2), "thumb,index", "1,2");
        assert!(matches!(read(&mut columns, other), Err(Fault::Malformed(_))), "{other}");
        assert_eq!(read(&mut columns, "thumb,index").unwrap(), None);
        assert!(matches!(read(&mut columns, "N,mV"), Err(Fault::Malformed(_))), "units");
        assert_eq!(good(&mut columns, "3,4").0, [3.0, 4.0]);
    }
}

#[test]
fn keys_that_change_end_the_stream_and_banners_do_not() {
    for (other, is_change) in [
        (r#"{"a":1,"c":2}"#, true),
        (r#"{"x":1,"y":2}"#, true),
        (r#"{"uptime":5}"#, false),
        (r#"{"message":"low power","level":"b"}"#, false),
        (r#"{"a":1}"#, false),
    ] {
        let mut columns = plain(&series(2));
        good(&mut columns, r#"{"a":1,"b":2}"#);
        match read(&mut columns, other) {
            Err(Fault::Names(why)) => assert!(is_change && why.contains("expected a, b"), "{other}: {why}"),
            Err(Fault::Malformed(_)) => assert!(!is_change, "{other}"),
            read => panic!("{other}: {read:?}"),
        }
        assert_eq!(good(&mut columns, r#"{"c":9,"a":1,"b":2}"#).0, [1.0, 2.0], "a key more");
    }
    let mut columns = plain(&series(2));
    for line in ["Logger v2 ready", "index,thumb"] {
        assert_eq!(read(&mut columns, line).unwrap(), None, "a banner before the header");
    }
    let names = ["thumb", "index"].map(String::from).to_vec();
    let known = SampleSpec { channel_names: names, ..series(2) };
    let mut banner = plain(&known);
    read(&mut banner, "Logger v2 ready").unwrap();
    read(&mut banner, "index,thumb").unwrap();
    assert_eq!(good(&mut banner, "1,2").0, [2.0, 1.0]);
}

#[test]
fn a_header_after_numbers_has_to_name_what_was_read() {
    let names = ["thumb", "index"].map(String::from).to_vec();
    let known = || plain(&SampleSpec { channel_names: names.clone(), ..series(2) });
    let mut same = known();
    good(&mut same, "1,2");
    assert_eq!(read(&mut same, "thumb,index").unwrap(), None);
    assert_eq!(good(&mut same, "3,4").0, [3.0, 4.0]);
    let mut other = known();
    good(&mut other, "1,2");
    let late = read(&mut other, "index,thumb");
    assert!(
        matches!(&late, Err(Fault::Names(why)) if why.contains("index, thumb") && why.contains("thumb, index"))
    );
}
