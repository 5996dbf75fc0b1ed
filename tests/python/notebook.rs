//! python/examples/classifier.ipynb from top to bottom: recipe, datasets, network, ONNX, `gen check` and a sweep.

use std::path::Path;

use crate::models::needs_onnxruntime;
use crate::scripts::interpreter;
use test_support::program::program;

/// Runs the code of a notebook's cells in one namespace, and prints what the last lines ask for.
const RUN: &str = "\
import json, sys
names = {'__name__': 'notebook'}
for cell in json.load(open(sys.argv[1]))['cells']:
    if cell['cell_type'] == 'code':
        assert not cell['outputs'], cell
        exec(compile(''.join(cell['source']), sys.argv[1], 'exec'), names)
print('accuracy:', names['accuracy']['accuracy'], names['right'])
swept = json.load(open(names['work'] / 'knots-sweep/sweep.json'))
print('swept:', len(swept['keys']), swept['samples'])
names['shutil'].rmtree(names['work'])
";

/// The network learns: of three classes, where chance is right in a third, it tells most windows of boards that it has
/// not seen.
#[test]
#[ignore = "long"]
fn the_notebook_of_a_classifier_runs() {
    needs_onnxruntime();
    let others = std::env::var_os("PATH").unwrap_or_default();
    let own = program().parent().map(Path::to_path_buf);
    let path = std::env::join_paths(own.into_iter().chain(std::env::split_paths(&others)));
    let run = interpreter()
        .args(["-c", RUN, "classifier.ipynb"])
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/python/examples"))
        .env("PATH", path.expect("folders without colons"))
        .output()
        .expect("python starts");
    let said = format!("{}{}", String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    println!("{said}");
    assert!(run.status.success(), "{said}\nif a package is missing: make venv");
    let line = said.lines().find_map(|line| line.strip_prefix("accuracy: ")).expect("it is told");
    let shares: Vec<f64> = line.split(' ').map(|share| share.parse().expect("a number")).collect();
    assert!(shares.iter().all(|share| *share > 0.6), "{line}");
    assert!(said.contains("swept: 3 10"), "{said}");
}
