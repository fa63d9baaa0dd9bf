//! Models against closed forms and plain paths. Fixed seeds.

mod agreement;
mod closed_forms;
mod measure;
mod support;
