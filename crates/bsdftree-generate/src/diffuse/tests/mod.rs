//! Models against closed forms and plain paths. Fixed seeds.

mod measure;
mod support;
