//! `seamwright render`: pictures of a UV-mapped mesh, whatever tool made it.

use crate::args::render::RenderArgs;
use crate::base::failure::Failure;
use crate::files::drafts::{self, Drafts};
use crate::formats::loaded::load_as;
use crate::formats::reading::Reading;
use crate::jobs::outputs::refuse_other_pictures;
use crate::picture::drawing::Drawing;
use crate::run::threads::Pool;

/// Runs `seamwright render`. Exposure is found by our own rays, charts from the UVs.
pub fn render(args: &RenderArgs) -> Result<(), Failure> {
    // A slip of the hand must not put a picture over the mesh.
    refuse_other_pictures(&[("-o", Some(&args.output))])?;
    drafts::check("-o", &args.output)?;
    let loaded = load_as(&args.file, Reading { uv_set: args.uv_set, ..Reading::default() })?;
    loaded.check_set(args.uv_set)?;
    let (mesh, corner_uv) = loaded.mapped()?;
    let pool = Pool::new(None).map_err(|e| Failure::Unreached(format!("cannot start threads: {e}")))?;
    let title = loaded.name();
    let picture = Drawing { title, mesh, corner_uv, polygon_chart: None, exposure: None }.png(&pool);
    let mut drafts = Drafts::new();
    drafts.add("-o", &args.output, |out| out.write_all(&picture))?;
    drafts.publish()
}
