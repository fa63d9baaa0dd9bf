//! Blocks as bytes and back.

use glam::DVec3;
use proptest::prelude::*;

use crate::checkpoint::encode::{decode, encode};
use crate::counts::{Block, Shape};
use crate::diffuse::Laid;
use crate::scatter::Flux;
use crate::tally::{Exit, Row};

const N_EXITANT: usize = 300;
const N_LAID: usize = 40;

/// Numbers that are often 0, of either sign.
fn some() -> impl Strategy<Value = f32> {
    prop_oneof![3 => Just(0.0), 1 => Just(-0.0), 3 => any::<f32>().prop_filter("a number", |x| !x.is_nan())]
}

fn row<S: Flux + std::fmt::Debug>() -> impl Strategy<Value = Row<S>> {
    let exit = (some(), [some(), some(), some()], prop::array::uniform8(some()));
    prop::collection::btree_map(0..N_EXITANT as u32, exit, 0..20).prop_map(|exits| {
        let exit = |(cell, (squares, sum, replicates)): (u32, (f32, [f32; 3], [f32; 8]))| Exit {
            cell,
            squares,
            sum: S::from_channels(|k| f64::from(sum[k]) / 3.0),
            replicates,
        };
        exits.into_iter().map(exit).collect()
    })
}

fn laid() -> impl Strategy<Value = Laid> {
    let numbers = || prop::collection::vec(some(), N_LAID);
    (numbers(), numbers()).prop_map(|(sent, arrived)| Laid { sent, arrived })
}

fn block<S: Flux + std::fmt::Debug>() -> impl Strategy<Value = Block<S>> {
    let rows = |n| [prop::collection::vec(row::<S>(), n), prop::collection::vec(row::<S>(), n)];
    (rows(2), rows(1), [laid(), laid()], any::<u64>(), 0.0..1e9).prop_map(
        |(rows, diffused, laid, lost, seconds)| Block {
            rows: vec![rows.clone(), rows],
            diffused: vec![diffused.clone(), diffused],
            laid: Some(laid),
            lost,
            seconds,
        },
    )
}

const SHAPE: Shape =
    Shape { n_bands: 2, n_rows: 2, n_diffused: 1, n_laid: Some(N_LAID), n_exitant: N_EXITANT };

fn comes_back<S: Flux + std::fmt::Debug>(block: &Block<S>) -> Result<(), TestCaseError> {
    let mut bytes = Vec::new();
    encode(&block.view(), &mut bytes);
    let again = decode::<S>(&bytes, &SHAPE).expect("bytes of a block");
    // Debug forms are exact, and tell −0 from 0.
    prop_assert_eq!(format!("{again:?}"), format!("{block:?}"));
    prop_assert!(decode::<S>(&bytes[..bytes.len() - 1], &SHAPE).is_none());
    bytes.push(0);
    prop_assert!(decode::<S>(&bytes, &SHAPE).is_none());
    Ok(())
}

proptest! {
    #[test]
    fn blocks_come_back_with_the_same_bits(grey in block::<f64>(), rgb in block::<DVec3>()) {
        comes_back(&grey)?;
        comes_back(&rgb)?;
    }

    #[test]
    fn any_bytes_are_a_block_or_none(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        if let Some(block) = decode::<f64>(&bytes, &SHAPE) {
            prop_assert_eq!(block.rows[1][0].len(), 2);
        }
    }
}

#[test]
fn cells_beyond_the_layout_are_no_block() {
    let block = Block {
        rows: vec![[vec![vec![Exit { squares: 1.0, sum: 1.0, ..Exit::none(7) }]], vec![Row::new()]]],
        ..Block::<f64>::nothing()
    };
    let mut bytes = Vec::new();
    encode(&block.view(), &mut bytes);
    let shape = |n_exitant| Shape { n_bands: 1, n_rows: 1, n_diffused: 0, n_laid: None, n_exitant };
    assert!(decode::<f64>(&bytes, &shape(8)).is_some());
    assert!(decode::<f64>(&bytes, &shape(7)).is_none());
}
