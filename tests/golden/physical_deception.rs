//! Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.
//!
//! profile     d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d
//! made by     tests, hand-made, preset none, seed 0
//!
//! A module that needs nothing of std (nor of alloc), so that it serves in `no_std` crates too. A module for each agent,
//! with `act`, which takes an observation and returns the action's number, and `finite`, which checks one.
//!
//! A split goes left iff x[feature] <= threshold, both f32, thresholds exact (written as their bits). NaN compares false
//! and so goes right; infinities follow <=. A thread that takes subnormal numbers for zero decides next to zero otherwise.
#![allow(dead_code)]

pub const PROFILE: &str = "d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d";

/// adversary_0, team adversaries: 1 leaves, at most 0 comparisons.
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

    #[allow(clippy::collapsible_else_if, unused_variables)]
    pub fn act(x: &[f32; N_FEATURES]) -> usize {
        A_STAY // leaf 0
    }

    pub fn finite(x: &[f32; N_FEATURES]) -> bool {
        x.iter().all(|value| value.is_finite())
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
}
