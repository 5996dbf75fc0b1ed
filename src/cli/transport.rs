//! `gen transport`: the answer of one model about one medium, as JSON.

use std::io::IsTerminal;
use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;
use serde_json::{Value, json};

use super::console::Console;
use super::progress::Progress;
use super::{CommandResult, DONE, output, print, whole};
use evidence::reference::medium::LayeredMedium;
use evidence::reference::model::Model;
use evidence::reference::path::Effort;
use transport::answer::{Answer, Estimate, LineSide};
use transport::kernel::Doubt;

/// Version of the document's layout.
const SCHEMA_VERSION: u32 = 1;
/// Largest number of photons: weeks of work.
const MAX_PHOTONS: u64 = 1_000_000_000_000;

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen transport --medium van-de-hulst --model path
  gen transport --medium clear-wood --model kernel --out clear.json
  gen transport --medium mine.yaml --model path --photons 10000000 --seed 1 --out mine.json

recipes/media/README.md explains every key of a medium. The same medium, model, photons and seed
give the same bytes for any number of threads.")]
pub(super) struct TransportArgs {
    /// Layers and question: a YAML file, - for standard input, or one that is built in (clear-wood, sealed-flange, ...)
    #[arg(long, value_name = "FILE")]
    medium: PathBuf,
    /// Who is asked
    #[arg(long, value_parser = PossibleValuesParser::new(Model::ALL.map(Model::name)))]
    model: String,
    /// Photons to walk, rounded up to 128 equal batches; models without chance take no notice
    #[arg(long, value_name = "N", default_value_t = Effort::default().photons,
          value_parser = clap::value_parser!(u64).range(1..=MAX_PHOTONS))]
    photons: u64,
    /// Seed of all chance
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = whole::<u64>)]
    seed: u64,
    /// Where the answer goes (JSON); - for standard output [default: standard output]
    #[arg(short, long, value_name = "FILE", value_parser = output::file_or_standard_output("json"))]
    out: Option<PathBuf>,
    /// Threads [default: all cores]
    #[arg(short = 'j', long, value_name = "T", value_parser = whole::<usize>)]
    threads: Option<usize>,
}

pub(super) fn run(arguments: &TransportArgs, console: &Console) -> CommandResult {
    let threads = super::generate::threads(arguments.threads)?;
    let model = Model::ALL.into_iter().find(|model| model.name() == arguments.model).ok_or("no such model")?;
    if let Some(known) =
        LayeredMedium::built_in(&arguments.medium).filter(|known| *known != arguments.medium.as_os_str())
    {
        console
            .note(&format!("there is no file {}: the built-in medium `{known}` is taken", arguments.medium.display()));
    }
    let medium = LayeredMedium::load(&arguments.medium)?;
    let out = arguments.out.as_ref().filter(|out| !output::is_standard_output(out));
    if let Some(out) = out {
        output::check_replaceable(out, output::Written::Json)?;
        output::check_writable(out)?;
    }
    let effort = Effort { photons: arguments.photons, seed: arguments.seed };
    let progress = Progress::new(console, "photons", Some(if model.walks() { effort.walked() } else { 0 }));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let answer = pool.install(|| model.ask(&medium.stack, &medium.question, effort, &|photons| progress.add(photons)));
    drop(progress);
    let answer = answer?;
    let doubt = if model == Model::Kernel { Doubt::of(&medium.stack, &medium.question)? } else { None };
    let document = format!("{:#}\n", document(model, effort, &medium, &answer, doubt)?);
    match out {
        Some(out) => output::write(out, document.as_bytes())?,
        None => print(&document)?,
    }
    if std::io::stderr().is_terminal() || out.is_some() {
        console.note(&summary(&answer));
    }
    if let Some(doubt) = doubt {
        console.note(&format!("in doubt: {doubt}; compare with `--model path`"));
    }
    Ok(DONE)
}

fn document(
    model: Model,
    effort: Effort,
    medium: &LayeredMedium,
    answer: &Answer,
    doubt: Option<Doubt>,
) -> Result<Value, serde_json::Error> {
    let effort = model.walks().then(|| json!({ "photons": effort.walked(), "seed": effort.seed }));
    let Value::Object(mut shown) = medium.json() else { return Ok(Value::Null) };
    let question = shown.shift_remove("question");
    Ok(json!({
        "schema_version": SCHEMA_VERSION,
        "program": format!("gen {}", env!("CARGO_PKG_VERSION")),
        "model": model.name(),
        "effort": effort,
        "medium": shown,
        "question": question,
        "in_doubt": doubt.map(|doubt| doubt.to_string()),
        "answer": serde_json::to_value(answer)?,
    }))
}

/// The answer in a few lines.
fn summary(answer: &Answer) -> String {
    let mut text = format!("model {}, shares of the incident light", answer.model);
    let mut line = |name: &str, estimate: Estimate| {
        let error = if estimate.error > 0.0 { format!(" +- {:.5}", estimate.error) } else { String::new() };
        text.push_str(&format!("\n  {name:24}{:9.5}{error}", estimate.value));
    };
    line("specular", Estimate::exact(answer.specular));
    line("diffusely reflected", answer.reflectance);
    line("transmitted", answer.transmittance);
    line("  never scattered", answer.unscattered);
    for (i, absorbed) in answer.absorbed.iter().enumerate() {
        line(&format!("absorbed in layer {}", i + 1), *absorbed);
    }
    if let Some(towards) = answer.towards_lens {
        line("radiance factor to lens", towards);
    }
    line("central row of a line", Estimate::exact(answer.rows(0, 0, LineSide::Both)));
    line("rows 1 to 8, both sides", Estimate::exact(answer.rows(1, 8, LineSide::Both)));
    text
}
