//! Fill-reducing ordering of the dofs.

use feral_metis::{CscPattern, metis_order};

use super::{ForwardError, Pattern};

/// Order of elimination of the free dofs (full dof numbers): multilevel nested dissection (Karypis
/// and Kumar 1998) of the graph of the nodes, which is a ninth of the dofs' graph, in
/// elimination-tree postorder so that the columns of a supernode are neighbours.
///
/// Minimum degree fills more on tissue as thick as a face's.
///
/// # Errors
/// [`ForwardError::Factorisation`] when the graph has more edges than 32-bit indices can count.
pub(crate) fn elimination_order(
    pattern: &Pattern,
    is_free: impl Fn(usize) -> bool,
) -> Result<Vec<usize>, ForwardError> {
    let n = pattern.n_nodes();
    let mut graph = vec![Vec::new(); n];
    let has_free = |node: usize| (3 * node..3 * node + 3).any(&is_free);
    for j in (0..n).filter(|&j| has_free(j)) {
        for &i in pattern.later_neighbours(j).iter().filter(|&&i| has_free(i)) {
            graph[i].push(j);
            graph[j].push(i);
        }
    }
    for neighbours in &mut graph {
        neighbours.sort_unstable();
    }
    let order = nested_dissection(&graph)?;
    Ok(postorder(&graph, &order)
        .into_iter()
        .flat_map(|node| 3 * node..3 * node + 3)
        .filter(|&dof| is_free(dof))
        .collect())
}

fn nested_dissection(graph: &[Vec<usize>]) -> Result<Vec<usize>, ForwardError> {
    let edges: usize = graph.iter().map(Vec::len).sum();
    let fail = |what: String| ForwardError::Factorisation(format!("ordering {} nodes: {what}", graph.len()));
    i32::try_from(edges.max(graph.len())).map_err(|e| fail(e.to_string()))?;
    let mut starts = vec![0];
    let mut neighbours = Vec::with_capacity(edges);
    for list in graph {
        neighbours.extend(list.iter().map(|&node| node as i32));
        starts.push(neighbours.len() as i32);
    }
    let pattern = CscPattern { n: graph.len(), col_ptr: &starts, row_idx: &neighbours };
    let order = metis_order(&pattern).map_err(|e| fail(e.to_string()))?;
    Ok(order.into_iter().map(|node| node as usize).collect())
}

/// `order` (position -> node) rearranged to a postorder of its elimination tree.
fn postorder(graph: &[Vec<usize>], order: &[usize]) -> Vec<usize> {
    const NONE: usize = usize::MAX;
    let n = order.len();
    let mut position = vec![0; n];
    for (k, &node) in order.iter().enumerate() {
        position[node] = k;
    }
    let (mut parent, mut ancestor) = (vec![NONE; n], vec![NONE; n]);
    for (k, &node) in order.iter().enumerate() {
        for &other in &graph[node] {
            let mut i = position[other];
            // Climb to the root of the subtree found so far, compressing the path onto k.
            while i < k {
                let next = std::mem::replace(&mut ancestor[i], k);
                if next == NONE {
                    parent[i] = k;
                    break;
                }
                i = next;
            }
        }
    }
    let mut children = vec![Vec::new(); n];
    for k in (0..n).rev() {
        if parent[k] != NONE {
            children[parent[k]].push(k);
        }
    }
    let mut out = Vec::with_capacity(n);
    for root in (0..n).filter(|&k| parent[k] == NONE) {
        let mut stack = vec![root];
        while let Some(&top) = stack.last() {
            match children[top].pop() {
                Some(child) => stack.push(child),
                None => {
                    stack.pop();
                    out.push(order[top]);
                }
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn postorder_puts_children_before_parents_and_keeps_every_node() {
        // A path eliminated from both ends: 0, 4, 1, 3, 2; the tree is two chains that meet in 2.
        let graph = [vec![1], vec![0, 2], vec![1, 3], vec![2, 4], vec![3]];
        let order = postorder(&graph, &[0, 4, 1, 3, 2]);
        assert_eq!(order, [0, 1, 4, 3, 2]);
    }
}
