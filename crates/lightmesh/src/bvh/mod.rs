//! The ray kernel.
