//! Files that import each other in circles.

use crate::arrows::Arrow;

/// The groups of files that reach each other (Tarjan's strongly connected components), each sorted.
pub fn circles(files: usize, arrows: &[Arrow]) -> Vec<Vec<usize>> {
    let mut next = vec![Vec::new(); files];
    for arrow in arrows {
        next[arrow.from].push(arrow.to);
    }
    let mut search = Search {
        next,
        index: vec![None; files],
        low: vec![0; files],
        on_stack: vec![false; files],
        stack: Vec::new(),
        count: 0,
        found: Vec::new(),
    };
    for file in 0..files {
        if search.index[file].is_none() {
            search.visit(file);
        }
    }
    search.found.sort();
    search.found
}

struct Search {
    next: Vec<Vec<usize>>,
    index: Vec<Option<usize>>,
    low: Vec<usize>,
    on_stack: Vec<bool>,
    stack: Vec<usize>,
    count: usize,
    found: Vec<Vec<usize>>,
}

impl Search {
    fn visit(&mut self, file: usize) -> usize {
        let own = self.count;
        self.index[file] = Some(own);
        self.low[file] = own;
        self.count += 1;
        self.stack.push(file);
        self.on_stack[file] = true;
        for to in self.next[file].clone() {
            match self.index[to] {
                None => {
                    let reached = self.visit(to);
                    self.low[file] = self.low[file].min(reached);
                }
                Some(index) if self.on_stack[to] => self.low[file] = self.low[file].min(index),
                Some(_) => {}
            }
        }
        if self.low[file] == own {
            let mut group = Vec::new();
            while let Some(member) = self.stack.pop() {
                self.on_stack[member] = false;
                group.push(member);
                if member == file {
                    break;
                }
            }
            if group.len() > 1 {
                group.sort_unstable();
                self.found.push(group);
            }
        }
        self.low[file]
    }
}
