//! Trees level by level: the one order in which files have them.
//!
//! Nodes follow each other by level, the root first, and within a level in the order of the slots that link to them. So the k-th
//! link of all slots is to node k (the root is node 0), a tree is determined by which of its slots are links and by its values, and
//! whether slots are a tree is seen in one pass over them.

use crate::tree::arena::{Arena, Content, MAX_LOG2_RES, Rank, Slot};

/// The slots of an arena in that order; without what its root does not lead to.
pub(crate) fn slots(arena: &Arena) -> Vec<Slot> {
    let mut slots = Vec::with_capacity(arena.n_nodes() * arena.rank().n_children());
    let mut nodes = Vec::with_capacity(arena.n_nodes());
    if let Content::Node(root) = arena.root().content() {
        nodes.push(root);
    }
    let mut next = 0;
    while let Some(&node) = nodes.get(next) {
        slots.extend(arena.children(node).iter().map(|&child| match child.content() {
            Content::Leaf(_) => child,
            Content::Node(node) => {
                nodes.push(node);
                Slot::link(nodes.len() as u32 - 1)
            }
        }));
        next += 1;
    }
    slots
}

/// The first slot that does not fit a tree of this depth in that order, and why.
pub(super) fn fault(slots: &[Slot], rank: Rank, log2_res: u32) -> Option<(usize, String)> {
    let n_children = rank.n_children();
    let n_nodes = slots.len() / n_children;
    // The node that the next link must lead to; the first node of the next level; the level.
    let (mut next, mut end, mut level) = (1, 0, 0);
    for (node, children) in slots.chunks_exact(n_children).enumerate() {
        if node >= next {
            return Some((node * n_children, format!("no link to node {node}")));
        }
        if node == end {
            (end, level) = (next, level + 1);
        }
        let at = |k: usize, what: String| Some((node * n_children + k, what));
        for (k, slot) in children.iter().enumerate() {
            match slot.content() {
                Content::Node(found) if found as usize != next => {
                    return at(k, format!("a link to node {found} where one to node {next} must be"));
                }
                Content::Node(_) => next += 1,
                Content::Leaf(value) if !slot.is_legal() => {
                    return at(k, format!("the value {value}, which is not finite"));
                }
                Content::Leaf(_) => {}
            }
        }
        if level > MAX_LOG2_RES {
            return at(0, format!("more than {MAX_LOG2_RES} levels"));
        }
    }
    let end = slots.len();
    if n_nodes > 0 && next != n_nodes {
        return Some((end, format!("links to {next} nodes where there are {n_nodes}")));
    }
    (level != log2_res).then(|| (end, format!("{level} levels where {log2_res} must be")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::{Tree, TreeBuilder};

    /// A tree with leaves on several levels.
    fn tree() -> Tree {
        let mut builder = TreeBuilder::new(Rank::Three);
        // One that no root leads to.
        builder.node(&[Slot::leaf(9.0); 8]).unwrap();
        let mut children: Vec<Slot> = (0..8).map(|k| Slot::leaf(k as f32)).collect();
        children[2] = builder.node(&children).unwrap();
        // Its own copy of that node is a node of its own in order.
        children[5] = builder.node(&children).unwrap();
        let root = builder.node(&children).unwrap();
        Tree::new(builder.finish(root))
    }

    #[test]
    fn nodes_are_in_order_of_the_links_to_them_and_all_are_reached() {
        let slots = slots(tree().arena());
        assert_eq!(slots.len(), 4 * 8);
        let links: Vec<u32> = slots
            .iter()
            .filter_map(|slot| match slot.content() {
                Content::Node(node) => Some(node),
                Content::Leaf(_) => None,
            })
            .collect();
        assert_eq!(links, [1, 2, 3]);
        assert_eq!(fault(&slots, Rank::Three, 3), None);
    }

    #[test]
    fn every_wrong_link_value_or_depth_is_found() {
        let slots = slots(tree().arena());
        assert!(fault(&slots, Rank::Three, 2).is_some());
        assert!(fault(&slots, Rank::Three, 4).is_some());
        assert!(fault(&slots[..24], Rank::Three, 3).is_some());
        for k in 0..slots.len() {
            let mut wrong = slots.clone();
            for slot in [Slot::link(0), Slot::link(k as u32 / 8), Slot::link(5), Slot::link(u32::MAX >> 1)] {
                wrong[k] = slot;
                let (found, _) = fault(&wrong, Rank::Three, 3).expect("a wrong link");
                assert!(found >= k, "{found} before {k}");
            }
            wrong[k] = bytemuck::cast(f32::NAN);
            assert_eq!(fault(&wrong, Rank::Three, 3).unwrap().0, k);
            wrong[k] = bytemuck::cast(f32::INFINITY);
            assert_eq!(fault(&wrong, Rank::Three, 3).unwrap().0, k);
        }
    }
}
