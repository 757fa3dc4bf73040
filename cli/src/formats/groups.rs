//! Groups of polygons, for formats that name them.

/// A group of each polygon.
pub struct Groups<'a> {
    /// Its number; beyond `names`: none of these, it stays in the group before it.
    pub of: &'a [u32], // (p)
    /// What stands after `g`.
    pub names: Vec<String>,
}

impl Groups<'_> {
    /// The name for polygon `p` where the polygon before it, since which the group was not `changed`, has another.
    pub(super) fn name(&self, p: usize, changed: bool) -> Option<&str> {
        let group = |p: usize| self.of.get(p).and_then(|g| self.names.get(*g as usize));
        group(p).filter(|name| changed || p == 0 || group(p - 1) != Some(*name)).map(String::as_str)
    }
}
