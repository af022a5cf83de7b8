//! Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.
//!
//! profile     d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d
//! made by     tests, hand-made, preset none, seed 0
//!
//! A module that needs nothing of std (nor of alloc), so that it serves in `no_std` crates too. A module for each agent,
//! with `act`, which takes an observation and returns the action's number, `act_rows` for many, one after the other, and
//! `finite` and `in_range`, which check one.
//! A world state has a number for each name of COORDINATES: `observe` is what the agent observes there, `act_world` its
//! action, and `act_team` of this module has the actions of all AGENTS. An observation is made as the reference
//! environment makes it: added in f64, then rounded to f32, to nearest.
//!
//! A split goes left iff x[feature] <= threshold, both f32, thresholds exact (written as their bits). NaN compares false
//! and so goes right; infinities follow <=. A thread that takes subnormal numbers for zero decides next to zero otherwise.
#![allow(dead_code)]

pub const PROFILE: &str = "d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d";
pub const AGENTS: [&str; 3] = ["adversary_0", "agent_0", "agent_1"];
/// Time of a step.
pub const DT: f64 = 0.1;
/// The share of its velocity that an agent loses in a step.
pub const DAMPING: f64 = 0.25;
/// Read by adversary_0, agent_0, agent_1.
pub const W_ADVERSARY_0_X: usize = 0;
/// Read by adversary_0, agent_0, agent_1.
pub const W_ADVERSARY_0_Y: usize = 1;
/// Read by adversary_0, agent_0, agent_1.
pub const W_AGENT_0_X: usize = 2;
/// Read by adversary_0, agent_0, agent_1.
pub const W_AGENT_0_Y: usize = 3;
/// Read by adversary_0, agent_0, agent_1.
pub const W_AGENT_1_X: usize = 4;
/// Read by adversary_0, agent_0, agent_1.
pub const W_AGENT_1_Y: usize = 5;
/// Read by adversary_0, agent_0, agent_1.
pub const W_LANDMARK_0_X: usize = 6;
/// Read by adversary_0, agent_0, agent_1.
pub const W_LANDMARK_0_Y: usize = 7;
/// Read by adversary_0, agent_0, agent_1.
pub const W_LANDMARK_1_X: usize = 8;
/// Read by adversary_0, agent_0, agent_1.
pub const W_LANDMARK_1_Y: usize = 9;
/// Read by agent_0, agent_1.
pub const W_GOAL_X: usize = 10;
/// Read by agent_0, agent_1.
pub const W_GOAL_Y: usize = 11;
/// Not read.
pub const W_ADVERSARY_0_VX: usize = 12;
/// Not read.
pub const W_ADVERSARY_0_VY: usize = 13;
/// Not read.
pub const W_AGENT_0_VX: usize = 14;
/// Not read.
pub const W_AGENT_0_VY: usize = 15;
/// Not read.
pub const W_AGENT_1_VX: usize = 16;
/// Not read.
pub const W_AGENT_1_VY: usize = 17;
pub const N_COORDINATES: usize = 18;
pub const COORDINATES: [&str; N_COORDINATES] = ["adversary_0.x", "adversary_0.y", "agent_0.x", "agent_0.y", "agent_1.x", "agent_1.y", "landmark_0.x", "landmark_0.y", "landmark_1.x", "landmark_1.y", "goal.x", "goal.y", "adversary_0.vx", "adversary_0.vy", "agent_0.vx", "agent_0.vy", "agent_1.vx", "agent_1.vy"];
/// The batch function of each of AGENTS.
pub const ACT_ROWS: [fn(&[f32], &mut [usize]); 3] = [adversary_0::act_rows, agent_0::act_rows, agent_1::act_rows];

/// The actions of all AGENTS in a world state.
pub fn act_team(w: &[f64; N_COORDINATES]) -> [usize; 3] {
    [adversary_0::act_world(w), agent_0::act_world(w), agent_1::act_world(w)]
}

/// adversary_0, team adversaries: 1 leaf, at most 0 comparisons.
pub mod adversary_0 {
    /// length, [-6.3, 6.3]: landmark_0.x - adversary_0.x
    pub const X_LANDMARK_0_DX: usize = 0;
    /// length, [-6.3, 6.3]: landmark_0.y - adversary_0.y
    pub const X_LANDMARK_0_DY: usize = 1;
    /// length, [-6.3, 6.3]: landmark_1.x - adversary_0.x
    pub const X_LANDMARK_1_DX: usize = 2;
    /// length, [-6.3, 6.3]: landmark_1.y - adversary_0.y
    pub const X_LANDMARK_1_DY: usize = 3;
    /// length, [-10.6, 10.6]: agent_0.x - adversary_0.x
    pub const X_AGENT_0_DX: usize = 4;
    /// length, [-10.6, 10.6]: agent_0.y - adversary_0.y
    pub const X_AGENT_0_DY: usize = 5;
    /// length, [-10.6, 10.6]: agent_1.x - adversary_0.x
    pub const X_AGENT_1_DX: usize = 6;
    /// length, [-10.6, 10.6]: agent_1.y - adversary_0.y
    pub const X_AGENT_1_DY: usize = 7;
    pub const N_FEATURES: usize = 8;

    pub const A_STAY: usize = 0;
    pub const A_LEFT: usize = 1;
    pub const A_RIGHT: usize = 2;
    pub const A_DOWN: usize = 3;
    pub const A_UP: usize = 4;
    pub const N_ACTIONS: usize = 5;

    /// What each feature measures, a sum of coordinates or a function of one; None: nobody said.
    pub const MEANINGS: [Option<&str>; N_FEATURES] = [Some("landmark_0.x - adversary_0.x"), Some("landmark_0.y - adversary_0.y"), Some("landmark_1.x - adversary_0.x"), Some("landmark_1.y - adversary_0.y"), Some("agent_0.x - adversary_0.x"), Some("agent_0.y - adversary_0.y"), Some("agent_1.x - adversary_0.x"), Some("agent_1.y - adversary_0.y")];
    /// The least and largest number of each feature.
    #[allow(clippy::excessive_precision)]
    pub const RANGES: [[f32; 2]; N_FEATURES] = [[-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727]];
    /// The direction in which each action pushes; None: it has none.
    pub const EFFECTS: [Option<[f64; 2]>; N_ACTIONS] = [Some([0.0, 0.0]), Some([-1.0, 0.0]), Some([1.0, 0.0]), Some([0.0, -1.0]), Some([0.0, 1.0])];
    /// What a unit action adds to a velocity per unit of time.
    pub const FORCE: f64 = 5.0;

    #[allow(clippy::collapsible_else_if, unused_variables)]
    pub fn act(x: &[f32; N_FEATURES]) -> usize {
        A_STAY // leaf 0
    }

    pub fn finite(x: &[f32; N_FEATURES]) -> bool {
        x.iter().all(|value| value.is_finite())
    }

    pub fn in_range(x: &[f32; N_FEATURES]) -> bool {
        x.iter().zip(RANGES.iter()).all(|(value, range)| *value >= range[0] && *value <= range[1])
    }

    /// Panics where `x` does not hold an observation for each of `actions`.
    pub fn act_rows(x: &[f32], actions: &mut [usize]) {
        assert_eq!(x.len(), N_FEATURES * actions.len());
        let mut seen = [0.0f32; N_FEATURES];
        for (row, action) in actions.iter_mut().enumerate() {
            seen.copy_from_slice(&x[row * N_FEATURES..(row + 1) * N_FEATURES]);
            *action = act(&seen);
        }
    }

    #[allow(unused_variables)]
    pub fn observe(w: &[f64; super::N_COORDINATES]) -> [f32; N_FEATURES] {
        [
            (w[super::W_LANDMARK_0_X] - w[super::W_ADVERSARY_0_X]) as f32, // landmark_0_dx
            (w[super::W_LANDMARK_0_Y] - w[super::W_ADVERSARY_0_Y]) as f32, // landmark_0_dy
            (w[super::W_LANDMARK_1_X] - w[super::W_ADVERSARY_0_X]) as f32, // landmark_1_dx
            (w[super::W_LANDMARK_1_Y] - w[super::W_ADVERSARY_0_Y]) as f32, // landmark_1_dy
            (w[super::W_AGENT_0_X] - w[super::W_ADVERSARY_0_X]) as f32, // agent_0_dx
            (w[super::W_AGENT_0_Y] - w[super::W_ADVERSARY_0_Y]) as f32, // agent_0_dy
            (w[super::W_AGENT_1_X] - w[super::W_ADVERSARY_0_X]) as f32, // agent_1_dx
            (w[super::W_AGENT_1_Y] - w[super::W_ADVERSARY_0_Y]) as f32, // agent_1_dy
        ]
    }

    pub fn act_world(w: &[f64; super::N_COORDINATES]) -> usize {
        act(&observe(w))
    }
}

/// agent_0, team defenders: 5 leaves, at most 3 comparisons.
pub mod agent_0 {
    /// length, [-6.3, 6.3]: goal.x - agent_0.x
    pub const X_GOAL_DX: usize = 0;
    /// length, [-6.3, 6.3]: goal.y - agent_0.y
    pub const X_GOAL_DY: usize = 1;
    /// length, [-6.3, 6.3]: landmark_0.x - agent_0.x
    pub const X_LANDMARK_0_DX: usize = 2;
    /// length, [-6.3, 6.3]: landmark_0.y - agent_0.y
    pub const X_LANDMARK_0_DY: usize = 3;
    /// length, [-6.3, 6.3]: landmark_1.x - agent_0.x
    pub const X_LANDMARK_1_DX: usize = 4;
    /// length, [-6.3, 6.3]: landmark_1.y - agent_0.y
    pub const X_LANDMARK_1_DY: usize = 5;
    /// length, [-10.6, 10.6]: adversary_0.x - agent_0.x
    pub const X_ADVERSARY_0_DX: usize = 6;
    /// length, [-10.6, 10.6]: adversary_0.y - agent_0.y
    pub const X_ADVERSARY_0_DY: usize = 7;
    /// length, [-10.6, 10.6]: agent_1.x - agent_0.x
    pub const X_AGENT_1_DX: usize = 8;
    /// length, [-10.6, 10.6]: agent_1.y - agent_0.y
    pub const X_AGENT_1_DY: usize = 9;
    pub const N_FEATURES: usize = 10;

    pub const A_STAY: usize = 0;
    pub const A_LEFT: usize = 1;
    pub const A_RIGHT: usize = 2;
    pub const A_DOWN: usize = 3;
    pub const A_UP: usize = 4;
    pub const N_ACTIONS: usize = 5;

    /// What each feature measures, a sum of coordinates or a function of one; None: nobody said.
    pub const MEANINGS: [Option<&str>; N_FEATURES] = [Some("goal.x - agent_0.x"), Some("goal.y - agent_0.y"), Some("landmark_0.x - agent_0.x"), Some("landmark_0.y - agent_0.y"), Some("landmark_1.x - agent_0.x"), Some("landmark_1.y - agent_0.y"), Some("adversary_0.x - agent_0.x"), Some("adversary_0.y - agent_0.y"), Some("agent_1.x - agent_0.x"), Some("agent_1.y - agent_0.y")];
    /// The least and largest number of each feature.
    #[allow(clippy::excessive_precision)]
    pub const RANGES: [[f32; 2]; N_FEATURES] = [[-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727]];
    /// The direction in which each action pushes; None: it has none.
    pub const EFFECTS: [Option<[f64; 2]>; N_ACTIONS] = [Some([0.0, 0.0]), Some([-1.0, 0.0]), Some([1.0, 0.0]), Some([0.0, -1.0]), Some([0.0, 1.0])];
    /// What a unit action adds to a velocity per unit of time.
    pub const FORCE: f64 = 5.0;

    #[allow(clippy::collapsible_else_if, unused_variables)]
    pub fn act(x: &[f32; N_FEATURES]) -> usize {
        if x[X_GOAL_DX] <= f32::from_bits(0x3dcccccc) { // node 0: 0.1
            if x[X_LANDMARK_0_DY] <= f32::from_bits(0x00000000) { // node 1: 0
                A_LEFT // leaf 2
            } else {
                A_RIGHT // leaf 3
            }
        } else {
            if x[X_AGENT_1_DY] <= f32::from_bits(0xbeaaaaab) { // node 4: -0.333333
                A_UP // leaf 5
            } else {
                if x[X_LANDMARK_0_DX] <= f32::from_bits(0x7f7fffff) { // node 6: 3.40282e+38
                    A_STAY // leaf 7
                } else {
                    A_STAY // leaf 8
                }
            }
        }
    }

    pub fn finite(x: &[f32; N_FEATURES]) -> bool {
        x.iter().all(|value| value.is_finite())
    }

    pub fn in_range(x: &[f32; N_FEATURES]) -> bool {
        x.iter().zip(RANGES.iter()).all(|(value, range)| *value >= range[0] && *value <= range[1])
    }

    /// Panics where `x` does not hold an observation for each of `actions`.
    pub fn act_rows(x: &[f32], actions: &mut [usize]) {
        assert_eq!(x.len(), N_FEATURES * actions.len());
        let mut seen = [0.0f32; N_FEATURES];
        for (row, action) in actions.iter_mut().enumerate() {
            seen.copy_from_slice(&x[row * N_FEATURES..(row + 1) * N_FEATURES]);
            *action = act(&seen);
        }
    }

    #[allow(unused_variables)]
    pub fn observe(w: &[f64; super::N_COORDINATES]) -> [f32; N_FEATURES] {
        [
            (w[super::W_GOAL_X] - w[super::W_AGENT_0_X]) as f32, // goal_dx
            (w[super::W_GOAL_Y] - w[super::W_AGENT_0_Y]) as f32, // goal_dy
            (w[super::W_LANDMARK_0_X] - w[super::W_AGENT_0_X]) as f32, // landmark_0_dx
            (w[super::W_LANDMARK_0_Y] - w[super::W_AGENT_0_Y]) as f32, // landmark_0_dy
            (w[super::W_LANDMARK_1_X] - w[super::W_AGENT_0_X]) as f32, // landmark_1_dx
            (w[super::W_LANDMARK_1_Y] - w[super::W_AGENT_0_Y]) as f32, // landmark_1_dy
            (w[super::W_ADVERSARY_0_X] - w[super::W_AGENT_0_X]) as f32, // adversary_0_dx
            (w[super::W_ADVERSARY_0_Y] - w[super::W_AGENT_0_Y]) as f32, // adversary_0_dy
            (w[super::W_AGENT_1_X] - w[super::W_AGENT_0_X]) as f32, // agent_1_dx
            (w[super::W_AGENT_1_Y] - w[super::W_AGENT_0_Y]) as f32, // agent_1_dy
        ]
    }

    pub fn act_world(w: &[f64; super::N_COORDINATES]) -> usize {
        act(&observe(w))
    }
}

/// agent_1, team defenders: 4 leaves, at most 3 comparisons.
pub mod agent_1 {
    /// length, [-6.3, 6.3]: goal.x - agent_1.x
    pub const X_GOAL_DX: usize = 0;
    /// length, [-6.3, 6.3]: goal.y - agent_1.y
    pub const X_GOAL_DY: usize = 1;
    /// length, [-6.3, 6.3]: landmark_0.x - agent_1.x
    pub const X_LANDMARK_0_DX: usize = 2;
    /// length, [-6.3, 6.3]: landmark_0.y - agent_1.y
    pub const X_LANDMARK_0_DY: usize = 3;
    /// length, [-6.3, 6.3]: landmark_1.x - agent_1.x
    pub const X_LANDMARK_1_DX: usize = 4;
    /// length, [-6.3, 6.3]: landmark_1.y - agent_1.y
    pub const X_LANDMARK_1_DY: usize = 5;
    /// length, [-10.6, 10.6]: adversary_0.x - agent_1.x
    pub const X_ADVERSARY_0_DX: usize = 6;
    /// length, [-10.6, 10.6]: adversary_0.y - agent_1.y
    pub const X_ADVERSARY_0_DY: usize = 7;
    /// length, [-10.6, 10.6]: agent_0.x - agent_1.x
    pub const X_AGENT_0_DX: usize = 8;
    /// length, [-10.6, 10.6]: agent_0.y - agent_1.y
    pub const X_AGENT_0_DY: usize = 9;
    pub const N_FEATURES: usize = 10;

    pub const A_STAY: usize = 0;
    pub const A_LEFT: usize = 1;
    pub const A_RIGHT: usize = 2;
    pub const A_DOWN: usize = 3;
    pub const A_UP: usize = 4;
    pub const N_ACTIONS: usize = 5;

    /// What each feature measures, a sum of coordinates or a function of one; None: nobody said.
    pub const MEANINGS: [Option<&str>; N_FEATURES] = [Some("goal.x - agent_1.x"), Some("goal.y - agent_1.y"), Some("landmark_0.x - agent_1.x"), Some("landmark_0.y - agent_1.y"), Some("landmark_1.x - agent_1.x"), Some("landmark_1.y - agent_1.y"), Some("adversary_0.x - agent_1.x"), Some("adversary_0.y - agent_1.y"), Some("agent_0.x - agent_1.x"), Some("agent_0.y - agent_1.y")];
    /// The least and largest number of each feature.
    #[allow(clippy::excessive_precision)]
    pub const RANGES: [[f32; 2]; N_FEATURES] = [[-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727]];
    /// The direction in which each action pushes; None: it has none.
    pub const EFFECTS: [Option<[f64; 2]>; N_ACTIONS] = [Some([0.0, 0.0]), Some([-1.0, 0.0]), Some([1.0, 0.0]), Some([0.0, -1.0]), Some([0.0, 1.0])];
    /// What a unit action adds to a velocity per unit of time.
    pub const FORCE: f64 = 5.0;

    #[allow(clippy::collapsible_else_if, unused_variables)]
    pub fn act(x: &[f32; N_FEATURES]) -> usize {
        if x[X_LANDMARK_1_DX] <= f32::from_bits(0xbd4ccccd) { // node 0: -0.05
            A_LEFT // leaf 1
        } else {
            if x[X_LANDMARK_1_DX] <= f32::from_bits(0x3d4ccccd) { // node 2: 0.05
                if x[X_LANDMARK_1_DY] <= f32::from_bits(0x00000000) { // node 3: 0
                    A_DOWN // leaf 4
                } else {
                    A_UP // leaf 5
                }
            } else {
                A_RIGHT // leaf 6
            }
        }
    }

    pub fn finite(x: &[f32; N_FEATURES]) -> bool {
        x.iter().all(|value| value.is_finite())
    }

    pub fn in_range(x: &[f32; N_FEATURES]) -> bool {
        x.iter().zip(RANGES.iter()).all(|(value, range)| *value >= range[0] && *value <= range[1])
    }

    /// Panics where `x` does not hold an observation for each of `actions`.
    pub fn act_rows(x: &[f32], actions: &mut [usize]) {
        assert_eq!(x.len(), N_FEATURES * actions.len());
        let mut seen = [0.0f32; N_FEATURES];
        for (row, action) in actions.iter_mut().enumerate() {
            seen.copy_from_slice(&x[row * N_FEATURES..(row + 1) * N_FEATURES]);
            *action = act(&seen);
        }
    }

    #[allow(unused_variables)]
    pub fn observe(w: &[f64; super::N_COORDINATES]) -> [f32; N_FEATURES] {
        [
            (w[super::W_GOAL_X] - w[super::W_AGENT_1_X]) as f32, // goal_dx
            (w[super::W_GOAL_Y] - w[super::W_AGENT_1_Y]) as f32, // goal_dy
            (w[super::W_LANDMARK_0_X] - w[super::W_AGENT_1_X]) as f32, // landmark_0_dx
            (w[super::W_LANDMARK_0_Y] - w[super::W_AGENT_1_Y]) as f32, // landmark_0_dy
            (w[super::W_LANDMARK_1_X] - w[super::W_AGENT_1_X]) as f32, // landmark_1_dx
            (w[super::W_LANDMARK_1_Y] - w[super::W_AGENT_1_Y]) as f32, // landmark_1_dy
            (w[super::W_ADVERSARY_0_X] - w[super::W_AGENT_1_X]) as f32, // adversary_0_dx
            (w[super::W_ADVERSARY_0_Y] - w[super::W_AGENT_1_Y]) as f32, // adversary_0_dy
            (w[super::W_AGENT_0_X] - w[super::W_AGENT_1_X]) as f32, // agent_0_dx
            (w[super::W_AGENT_0_Y] - w[super::W_AGENT_1_Y]) as f32, // agent_0_dy
        ]
    }

    pub fn act_world(w: &[f64; super::N_COORDINATES]) -> usize {
        act(&observe(w))
    }
}
