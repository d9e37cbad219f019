use super::{good_tree, repository};
use crate::support::sandbox::Sandbox;

fn with(text: &str) -> Sandbox {
    let sandbox = good_tree();
    std::fs::write(sandbox.path("m.toml"), text).unwrap();
    sandbox
}

#[test]
fn every_option_may_stand_in_the_file() {
    let sandbox = with(
        "# a batch\niso = [50, 60.5]\nrecursive = true\noutput = \"out\"\nformat = \"ply\"\n\
         quiet = true\njson = true\ninvert = false\njobs = 2\n\"max-memory\" = \"1G\"\n\
         crop = \"0:9,0:9,0:9\"\n",
    );
    let (said, reported) = sandbox.ends(0, "in/a --config m.toml --json");
    assert_eq!((said.as_str(), reported.len()), ("", 4));
    assert!(sandbox.names("out").contains(&"u8_iso60.5.ply".to_owned()));
    assert_eq!(reported[0]["dims"], serde_json::json!([9, 9, 9]));
}

#[test]
fn the_command_line_wins() {
    let sandbox = with("iso = [1, 2]\nformat = \"ply\"\nspace = \"lps\"\nverbose = true\n");
    let words = "in/a/u8.nii --config m.toml --iso 50 --format obj -o out/ --json -q";
    let (_, reported) = sandbox.ends(0, words);
    assert_eq!(sandbox.names("out"), ["u8.obj"]);
    assert_eq!(reported[0]["iso"], 50.0);
    assert_eq!(reported[0]["space"], "lps");
    // What cannot stand beside what was typed is overruled too.
    let (_, reported) = sandbox.ends(0, "in/a/u8.nii --config m.toml --mask 120 -o m.stl --json");
    assert!(reported[0]["iso"].is_null());
}

#[test]
fn what_is_wrong_with_the_file_is_told_before_any_work() {
    for (text, said, hint) in [
        ("is = 3\n", "no option is called \"is\"", "is iso meant?"),
        ("threds = 3\n", "no option is called \"threds\"", "is threads meant?"),
        ("zzzzzzzz = 3\n", "no option is called \"zzzzzzzz\"", "keys are the long options"),
        ("config = \"x\"\n", "no option is called \"config\"", ""),
        ("iso = true\n", "iso: expected a text, a number or a list of them, found boolean", ""),
        ("invert = 1\n", "invert: expected true or false, found integer", ""),
        ("[iso]\nx = 1\n", "found table", ""),
        ("iso = 3\niso = 4\n", "line 2: ", ""),
        ("\niso = \n", "line 2: ", ""),
        ("iso = \"bones\"\n", "bones", ""),
        ("threads = -1\n", "threads", ""),
    ] {
        let sandbox = with(text);
        let (told, reported) = sandbox.ends(2, "in/a/u8.nii --config m.toml -o m.stl --json");
        assert!(told.starts_with("error: m.toml: "), "{text}: {told}");
        assert!(told.contains(said) && told.contains(hint), "{text}: {told}");
        assert_eq!(reported[0]["error"]["kind"], "bad-config", "{text}");
        assert_eq!(sandbox.files().len(), 2);
    }
    let sandbox = with("");
    let (told, reported) = sandbox.ends(2, "in/a/u8.nii --config gone.toml --json");
    assert!(told.contains("gone.toml: does not exist"), "{told}");
    assert_eq!(reported[0]["error"]["kind"], "bad-config");
    let (told, reported) = sandbox.ends(2, "in/a/u8.nii --config in --json");
    assert!(told.starts_with("error: in: "), "{told}");
    assert_eq!(reported[0]["error"]["kind"], "bad-config");
    std::fs::write(sandbox.path("long.toml"), "# no end\n".repeat(150_000)).unwrap();
    let (told, _) = sandbox.ends(2, "in/a/u8.nii --config long.toml --json");
    assert!(told.contains("long.toml: has more than 1048576 bytes"), "{told}");
    sandbox.copy(&repository("testdata/ct_head.nii.gz"), "bytes.toml");
    sandbox.ends(2, "in/a/u8.nii --config bytes.toml --json");
}

#[test]
fn json_in_the_file_counts_for_what_is_wrong_with_it() {
    for wrong in ["iso = \"bones\"", "threds = 3", "invert = 1"] {
        let sandbox = with(&format!("{wrong}\njson = true\n"));
        let words = ["in/a/u8.nii", "--config", "m.toml", "-o", "m.stl"];
        let output = sandbox.run(&words);
        assert_eq!(output.status.code(), Some(2), "{wrong}");
        let reported = crate::support::sandbox::object(&output);
        assert_eq!(reported["error"]["kind"], "bad-config", "{wrong}");
    }
}
