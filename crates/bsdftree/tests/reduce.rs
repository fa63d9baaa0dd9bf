//! Reduced trees: bounds that hold, light that is kept, and the least error there can be, by trying all prunings of small trees.

mod common;

use bsdftree::reduce::{Goal, Norm, ReduceError};
use bsdftree::tree::{Leaf, Slot, TreeBuilder};
use bsdftree::{Rank, Tree};
use common::{Random, random_tree};
use proptest::prelude::*;

/// A tree of random values on all levels, whose branches are alike inside, as those of a BSDF are.
fn grid(rank: Rank, log2: u32, seed: u64) -> Tree {
    let mut random = Random(seed);
    let d = rank.dimensions() as u32;
    let levels: Vec<Vec<f64>> =
        (0..=log2).map(|l| (0..1 << (d * l)).map(|_| random.unit()).collect()).collect();
    let value = |k: usize| {
        let at = |i: u32| k >> ((d - 1 - i) * log2) & ((1 << log2) - 1);
        let sum = (0..=log2).map(|l| {
            let index = (0..d).fold(0, |index, i| index << l | at(i) >> (log2 - l));
            levels[l as usize][index].powi(6) * 0.5f64.powi(l as i32)
        });
        sum.sum::<f64>() as f32
    };
    Tree::from_grid(rank, &(0..1 << (d * log2)).map(value).collect::<Vec<_>>()).unwrap()
}

fn inside(leaf: &Leaf, part: &Leaf, dimensions: usize) -> bool {
    part.level >= leaf.level
        && (0..dimensions).all(|i| part.cell[i] >> (part.level - leaf.level) == leaf.cell[i])
}

#[test]
fn every_leaf_is_the_mean_of_what_it_was() {
    let tree = grid(Rank::Four, 3, 1);
    let (reduced, _) = tree.reduced(&Goal { l1: Some(0.3), ..Goal::default() }).unwrap();
    assert!(reduced.arena().n_leaves() < tree.arena().n_leaves() / 2);
    for leaf in reduced.leaves() {
        let parts = tree.leaves().filter(|part| inside(&leaf, part, 4));
        let sum: f64 =
            parts.map(|part| f64::from(part.value) * 16f64.powi(leaf.level as i32 - part.level as i32)).sum();
        assert!((sum / f64::from(leaf.value) - 1.0).abs() < 1e-6, "{sum} {leaf:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn bounds_hold_and_losses_are_those_of_the_result(
        seed in 0u64..1000, l1 in prop::option::of(0.0..0.8f64), rms in prop::option::of(0.0..0.8f64),
        total in prop::option::of(0.0..0.3f64), four in any::<bool>(),
    ) {
        prop_assume!(l1.is_some() || rms.is_some() || total.is_some());
        let tree = random_tree(if four { Rank::Four } else { Rank::Three }, if four { 3 } else { 5 }, &mut Random(seed));
        let (reduced, loss) = tree.reduced(&Goal { l1, rms, total, ..Goal::default() }).unwrap();
        prop_assert_eq!(tree.loss_of(&reduced).unwrap(), loss);
        prop_assert!(l1.is_none_or(|bound| loss.l1 <= bound), "{loss:?}");
        prop_assert!(rms.is_none_or(|bound| loss.rms <= bound), "{loss:?}");
        prop_assert!(total.is_none_or(|bound| loss.worst_total <= bound), "{loss:?}");
        prop_assert!(loss.mean_total <= loss.worst_total + 1e-15);
        prop_assert!(reduced.arena().n_leaves() <= tree.arena().n_leaves());
    }
}

/// The least error of all prunings with at most so many leaves: `least[n - 1]`.
fn least(tree: &Tree, slot: Slot, level: u32, norm: Norm, most: usize) -> Vec<f64> {
    use bsdftree::tree::Content;
    let mut least = vec![f64::INFINITY; most];
    let Content::Node(node) = slot.content() else { return vec![0.0; most] };
    // As a leaf.
    let mut values = Vec::new();
    collect(tree, slot, 1.0, &mut values);
    let mean: f64 = values.iter().map(|(v, w)| v * w).sum();
    let mean = f64::from(mean as f32);
    let volume = 0.5f64.powi((tree.rank().dimensions() as u32 * level) as i32);
    let of = |d: f64| if norm == Norm::L1 { d.abs() } else { d * d };
    least[0] = values.iter().map(|(v, w)| w * of(v - mean)).sum::<f64>() * volume;
    // As a node: every way to share leaves among the children.
    let mut shared = vec![f64::INFINITY; most + 1];
    shared[0] = 0.0;
    for &child in tree.arena().children(node) {
        let below = self::least(tree, child, level + 1, norm, most);
        let mut next = vec![f64::INFINITY; most + 1];
        for (n, &error) in shared.iter().enumerate().filter(|(_, e)| e.is_finite()) {
            for k in 1..=most.saturating_sub(n) {
                next[n + k] = next[n + k].min(error + below[k - 1]);
            }
        }
        shared = next;
    }
    for n in 1..=most {
        least[n - 1] = least[n - 1].min(shared[n]);
    }
    for n in 1..most {
        least[n] = least[n].min(least[n - 1]);
    }
    least
}

fn collect(tree: &Tree, slot: Slot, weight: f64, values: &mut Vec<(f64, f64)>) {
    use bsdftree::tree::Content;
    match slot.content() {
        Content::Leaf(value) => values.push((f64::from(value), weight)),
        Content::Node(node) => {
            let children = tree.arena().children(node);
            children.iter().for_each(|&c| collect(tree, c, weight / children.len() as f64, values));
        }
    }
}

#[test]
fn no_pruning_of_as_few_leaves_has_a_smaller_error() {
    for (seed, norm) in [(1, Norm::L1), (2, Norm::Rms), (3, Norm::L1), (4, Norm::Rms)] {
        let tree = grid(Rank::Four, 2, seed);
        let whole = tree.arena().n_leaves();
        let least = least(&tree, tree.arena().root(), 0, norm, whole);
        let (light, power) = tree.leaves().fold((0.0, 0.0), |(light, power), leaf| {
            let (v, w) = (f64::from(leaf.value), 16f64.powi(-(leaf.level as i32)));
            (light + v * w, power + v * v * w)
        });
        let mut found = 0;
        for asked in (1..=whole).step_by(5) {
            let goal = Goal { n_leaves: Some(asked), norm, ..Goal::default() };
            let (reduced, loss) = tree.reduced(&goal).unwrap();
            let n = reduced.arena().n_leaves();
            // A node more or less is 15 leaves.
            assert!(n <= asked && n + 15 > asked.min(whole), "{n} {asked}");
            found += usize::from(n > 1 && n < whole);
            let error = if norm == Norm::L1 { loss.l1 * light } else { loss.rms * loss.rms * power };
            assert!((error - least[n - 1]).abs() <= 1e-6 * least[0], "{n}: {error} {}", least[n - 1]);
        }
        assert!(found > 20);
    }
}

#[test]
fn goals_that_cannot_be_are_refused() {
    let tree = grid(Rank::Three, 3, 5);
    assert_eq!(tree.reduced(&Goal::default()).unwrap_err(), ReduceError::NoGoal);
    let bound = |l1: f64| tree.reduced(&Goal { l1: Some(l1), ..Goal::default() });
    assert!(matches!(bound(-0.1), Err(ReduceError::Bound("L1", _))));
    assert!(matches!(bound(f64::NAN), Err(ReduceError::Bound("L1", _))));
    let both = Goal { l1: Some(0.01), n_leaves: Some(2), ..Goal::default() };
    assert!(matches!(tree.reduced(&both), Err(ReduceError::Leaves { asked: 2, .. })));
    assert_eq!(tree.loss_of(&grid(Rank::Four, 2, 1)), Err(ReduceError::NoPart));
    assert_eq!(Tree::uniform(Rank::Three, 1.0).loss_of(&tree), Err(ReduceError::NoPart));
    let mut builder = TreeBuilder::new(Rank::Four);
    let mut slot = Slot::leaf(1.0);
    for _ in 0..13 {
        let mut children = [Slot::leaf(0.5); 16];
        children[3] = slot;
        slot = builder.node(&children).unwrap();
    }
    let deep = Tree::new(builder.finish(slot));
    assert_eq!(
        deep.reduced(&Goal { l1: Some(0.1), ..Goal::default() }).unwrap_err(),
        ReduceError::TooFine(13)
    );
    assert_eq!(deep.loss_of(&deep), Err(ReduceError::TooFine(13)));
}

#[test]
fn what_is_uniform_or_black_is_one_leaf() {
    for value in [0.0, 2.5] {
        let mut builder = TreeBuilder::new(Rank::Four);
        let root = builder.node(&[Slot::leaf(value); 16]).unwrap();
        let tree = Tree::new(builder.finish(root));
        let (reduced, loss) = tree.reduced(&Goal { l1: Some(0.0), ..Goal::default() }).unwrap();
        assert_eq!((reduced.arena().n_leaves(), loss.l1, loss.worst_total), (1, 0.0, 0.0));
    }
    let leaf = Tree::uniform(Rank::Three, 1.0);
    assert_eq!(leaf.reduced(&Goal { n_leaves: Some(1), ..Goal::default() }).unwrap().0.arena().n_leaves(), 1);
}

#[test]
fn nodes_out_of_order_give_the_same_tree() {
    let tree = random_tree(Rank::Four, 4, &mut Random(7));
    let bsdft = {
        let mut bsdf = bsdftree::Bsdf::default();
        let component = bsdftree::Component::grey(tree.clone().into());
        bsdf.band_mut("Visible").insert(bsdftree::Part::ReflectionBack, component);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ordered.bsdft");
        bsdftree::file::write(&bsdf, &path, bsdftree::binary::Packing::Raw).unwrap();
        bsdftree::file::read(&path, bsdftree::xml::Strictness::Strict).unwrap().0
    };
    let component = bsdft.bands[0].component(bsdftree::Part::ReflectionBack).unwrap();
    let bsdftree::Scattering::Tree(ordered) = &component.luminance else { panic!("it is a tree") };
    let goal = Goal { l1: Some(0.2), total: Some(0.05), ..Goal::default() };
    let (a, b) = (tree.reduced(&goal).unwrap(), ordered.reduced(&goal).unwrap());
    assert!(a.0.leaves().eq(b.0.leaves()));
    assert_eq!(a.1, b.1);
}

/// Values of a grid, some of them equal to their neighbours.
fn values(rank: Rank, log2: u32, seed: u64, scale: f32) -> Vec<f32> {
    let grid = grid(rank, log2, seed).to_grid(log2);
    grid.into_iter().map(|v| if v < 0.1 { 0.0 } else { v * scale }).collect()
}

#[test]
fn grids_are_reduced_as_the_trees_of_them_are() {
    for (rank, log2) in [(Rank::Three, 4), (Rank::Three, 1), (Rank::Four, 3), (Rank::Four, 1)] {
        for (seed, scale) in [(1, 1.0), (2, 1e11), (3, 1e-30)] {
            let values = values(rank, log2, seed, scale);
            let tree = Tree::from_grid(rank, &values).unwrap();
            let n = tree.arena().n_leaves();
            for goal in [
                Goal { l1: Some(0.05), ..Goal::default() },
                Goal { l1: Some(0.0), ..Goal::default() },
                Goal { rms: Some(0.05), ..Goal::default() },
                Goal { l1: Some(0.2), total: Some(0.01), ..Goal::default() },
                Goal { total: Some(0.02), norm: Norm::Rms, ..Goal::default() },
                Goal { n_leaves: Some(n / 3), ..Goal::default() },
                Goal { n_leaves: Some(n / 2), norm: Norm::Rms, ..Goal::default() },
            ] {
                let (from_tree, a) = tree.reduced(&goal).unwrap();
                let (from_grid, b) = Tree::reduced_from_grid(rank, &values, &goal).unwrap();
                // Sums are made in another order, which decides between branches that are alike but for rounding.
                let [m, n] = [&from_tree, &from_grid].map(|tree| tree.arena().n_leaves());
                assert!(m.abs_diff(n) <= 15, "{rank:?} 2^{log2} {goal:?}: {m} {n} leaves");
                assert!(
                    (a.l1 - b.l1).abs() <= 1e-6 + 0.05 * a.l1 && (a.rms - b.rms).abs() <= 1e-6 + 0.05 * a.rms,
                    "{a:?} {b:?}"
                );
                let of_result = tree.loss_of(&from_grid).unwrap();
                assert!((of_result.l1 - b.l1).abs() < 1e-12 && (of_result.rms - b.rms).abs() < 1e-12);
                assert!((of_result.worst_total - b.worst_total).abs() < 1e-12);
                assert!(
                    goal.l1.is_none_or(|bound| b.l1 <= bound) && goal.rms.is_none_or(|bound| b.rms <= bound)
                );
                assert!(goal.total.is_none_or(|bound| b.worst_total <= bound), "{b:?}");
                assert!(goal.n_leaves.is_none_or(|most| n <= most));
            }
        }
    }
    let one =
        Tree::reduced_from_grid(Rank::Four, &[0.3], &Goal { l1: Some(0.1), ..Goal::default() }).unwrap();
    assert_eq!((one.0.arena().n_leaves(), one.1.worst_total), (1, 0.0));
    let bad =
        Tree::reduced_from_grid(Rank::Three, &[f32::NAN; 8], &Goal { l1: Some(0.1), ..Goal::default() });
    assert!(matches!(bad, Err(ReduceError::Grid(_))));
}

#[test]
fn values_at_the_ends_of_their_range_are_reduced() {
    let mut builder = TreeBuilder::new(Rank::Four);
    let mut children = [Slot::leaf(1e-30); 16];
    children[3] = Slot::leaf(f32::MAX);
    children[4] = builder.node(&std::array::from_fn::<_, 16, _>(|k| Slot::leaf(k as f32 * 1e-38))).unwrap();
    let root = builder.node(&children).unwrap();
    let tree = Tree::new(builder.finish(root));
    for goal in [
        Goal { l1: Some(0.1), ..Goal::default() },
        Goal { rms: Some(0.1), ..Goal::default() },
        Goal { n_leaves: Some(20), norm: Norm::Rms, ..Goal::default() },
    ] {
        let (reduced, loss) = tree.reduced(&goal).unwrap();
        assert_eq!(reduced.arena().n_leaves(), 16, "{goal:?} {loss:?}");
    }
}

/// Light below two slots of a level, one of a whole tree, the other of a smaller one, whose nodes are to have the same; how many it has.
fn same_light(trees: [&Tree; 2], slots: [Slot; 2], level: u32) -> ([f64; 2], usize) {
    use bsdftree::tree::Content;
    let light = |value: f32| f64::from(value) * 0.5f64.powi(4 * level as i32);
    match slots.map(Slot::content) {
        [Content::Leaf(a), Content::Leaf(b)] => ([light(a), light(b)], 0),
        [Content::Node(_), Content::Leaf(b)] => {
            let mut values = Vec::new();
            collect(trees[0], slots[0], 1.0, &mut values);
            ([light(values.iter().map(|(v, w)| v * w).sum::<f64>() as f32), light(b)], 0)
        }
        [Content::Node(a), Content::Node(b)] => {
            let pairs = trees[0].arena().children(a).iter().zip(trees[1].arena().children(b));
            let below = pairs.map(|(&x, &y)| same_light(trees, [x, y], level + 1));
            let (sums, n) = below.fold(([0.0; 2], 1), |(s, n), (t, m)| ([s[0] + t[0], s[1] + t[1]], n + m));
            assert!((sums[0] - sums[1]).abs() <= 1e-6 * sums[0], "{sums:?}");
            (sums, n)
        }
        [Content::Leaf(_), Content::Node(_)] => panic!("a reduced tree is nowhere finer"),
    }
}

#[test]
fn leaves_give_light_to_each_other_but_nodes_keep_theirs() {
    for seed in 1..6 {
        let tree = grid(Rank::Four, 3, seed);
        let few = Goal { n_leaves: Some(tree.arena().n_leaves() / 4), ..Goal::default() };
        let (plain, before) = tree.reduced(&few).unwrap();
        for norm in [Norm::L1, Norm::Rms] {
            let bound = before.worst_total / 5.0;
            let (balanced, after) = tree.reduced(&Goal { balance: Some(bound), norm, ..few }).unwrap();
            assert!(after.worst_total <= 0.5 * before.worst_total, "{before:?} {after:?}");
            assert_eq!(tree.loss_of(&balanced).unwrap(), after);
            assert!(balanced.arena().n_leaves() <= plain.arena().n_leaves() + 15);
            let roots = [tree.arena().root(), balanced.arena().root()];
            assert_eq!(same_light([&tree, &balanced], roots, 0).1, balanced.arena().n_nodes());
        }
        let bounded = Goal { l1: Some(0.2), balance: Some(0.0), ..Goal::default() };
        assert!(tree.reduced(&bounded).unwrap().1.l1 <= 0.2);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]
    #[test]
    fn balancing_never_makes_the_worst_total_worse(seed in 0u64..1000, balance in 0.0..0.1f64, four in any::<bool>()) {
        let tree = random_tree(if four { Rank::Four } else { Rank::Three }, if four { 3 } else { 5 }, &mut Random(seed));
        if tree.arena().log2_res() > 0 {
            let rank = tree.rank();
            let values = tree.to_grid(tree.arena().log2_res());
            let goal = Goal { l1: Some(0.2), balance: Some(balance), ..Goal::default() };
            let (balanced, loss) = Tree::reduced_from_grid(rank, &values, &goal).unwrap();
            let whole = Tree::from_grid(rank, &values).unwrap().loss_of(&balanced).unwrap();
            prop_assert!((whole.l1 - loss.l1).abs() < 1e-9 && whole.l1 <= 0.2 * (1.0 + 1e-9), "{whole:?} {loss:?}");
        }
        let goal = Goal { n_leaves: Some(tree.arena().n_leaves() / 3 + 1), ..Goal::default() };
        let (_, before) = tree.reduced(&goal).unwrap();
        let (balanced, after) = tree.reduced(&Goal { balance: Some(balance), ..goal }).unwrap();
        prop_assert!(after.worst_total <= before.worst_total);
        prop_assert_eq!(tree.loss_of(&balanced).unwrap(), after);
    }
}
