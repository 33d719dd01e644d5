//! Directed graphs over dense numbers: who comes after whom, and which go round in circles.

use std::ops::Range;

/// For each node those that follow it, as a compressed adjacency list.
pub struct Graph {
    start: Vec<u32>,
    list: Vec<u32>,
}

/// An order of all nodes of a graph, each after those that it follows.
pub struct Sorted {
    /// Every node once.
    pub sequence: Vec<u32>,
    /// Ranges of `sequence` whose nodes follow each other in a circle.
    pub groups: Vec<Range<usize>>,
}

impl Graph {
    /// A graph of `n` nodes from a walk over the edges that calls what it is given with the two ends of each. The far
    /// ends may be things of another kind, as long as nobody sorts them.
    pub fn new(n: usize, walk: impl Fn(&mut dyn FnMut(u32, u32))) -> Graph {
        let mut start = vec![0u32; n + 1];
        walk(&mut |from, _| start[from as usize + 1] += 1);
        for i in 0..n {
            start[i + 1] += start[i];
        }
        let mut at = start.clone();
        let mut list = vec![0; start[n] as usize];
        walk(&mut |from, to| {
            list[at[from as usize] as usize] = to;
            at[from as usize] += 1;
        });
        Graph { start, list }
    }

    /// Whether there are no nodes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many nodes there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// The nodes that follow one.
    pub fn after(&self, node: u32) -> &[u32] {
        &self.list[self.start[node as usize] as usize..self.start[node as usize + 1] as usize]
    }

    /// Every edge the other way round.
    pub fn reversed(&self) -> Graph {
        Graph::new(self.len(), |f| {
            for from in 0..self.len() as u32 {
                self.after(from).iter().for_each(|&to| f(to, from));
            }
        })
    }

    /// Sorts the nodes, by Tarjan's strongly connected components (iterative: chains may be long).
    pub fn sorted(&self) -> Sorted {
        const UNSEEN: u32 = u32::MAX;
        let n = self.len();
        let (mut index, mut low) = (vec![UNSEEN; n], vec![0u32; n]);
        let mut on_stack = vec![false; n];
        let (mut stack, mut work): (Vec<u32>, Vec<(u32, u32)>) = (Vec::new(), Vec::new());
        let mut next = 0;
        let mut sorted = Sorted { sequence: Vec::with_capacity(n), groups: Vec::new() };
        for root in 0..n as u32 {
            if index[root as usize] != UNSEEN {
                continue;
            }
            work.push((root, 0));
            while let Some(&mut (node, ref mut edge)) = work.last_mut() {
                let c = node as usize;
                if *edge == 0 && index[c] == UNSEEN {
                    (index[c], low[c]) = (next, next);
                    next += 1;
                    stack.push(node);
                    on_stack[c] = true;
                }
                if let Some(&to) = self.after(node).get(*edge as usize) {
                    *edge += 1;
                    if index[to as usize] == UNSEEN {
                        work.push((to, 0));
                    } else if on_stack[to as usize] {
                        low[c] = low[c].min(index[to as usize]);
                    }
                    continue;
                }
                work.pop();
                if let Some(&(parent, _)) = work.last() {
                    low[parent as usize] = low[parent as usize].min(low[c]);
                }
                if low[c] == index[c] {
                    let begin = sorted.sequence.len();
                    while let Some(member) = stack.pop() {
                        on_stack[member as usize] = false;
                        sorted.sequence.push(member);
                        if member == node {
                            break;
                        }
                    }
                    let end = sorted.sequence.len();
                    if end - begin > 1 || self.after(node).contains(&node) {
                        sorted.groups.push(begin..end);
                    }
                }
            }
        }
        // components come out last first
        sorted.sequence.reverse();
        for group in &mut sorted.groups {
            *group = n - group.end..n - group.start;
        }
        sorted.groups.reverse();
        sorted
    }
}
