//! Arguments of `completions`.

use clap::Args;
use clap_complete::Shell;

/// Whose completions.
#[derive(Debug, Args)]
#[command(after_help = NOTES)]
pub(crate) struct CompletionsArgs {
    /// The shell that will read them
    pub(crate) shell: Shell,
}

const NOTES: &str = "\
Where they go:
  lightmesh completions bash > ~/.local/share/bash-completion/completions/lightmesh
  lightmesh completions zsh > DIR/_lightmesh, with DIR in $fpath
  lightmesh completions fish > ~/.config/fish/completions/lightmesh.fish
  lightmesh completions powershell >> $PROFILE";
