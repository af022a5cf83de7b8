; Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.
;
; profile     d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d
; made by     tests, hand-made, preset none, seed 0
;
; SMT-LIB 2, theory FloatingPoint: a function for each agent, from an observation of Float32 to the action's number.
; A split goes left iff feature <= threshold (fp.leq: false for NaN, so that NaN goes right; -0 and +0 are equal).

; adversary_0, team adversaries: 1 leaf; 0 stay, 1 left, 2 right, 3 down, 4 up
(define-fun physical_deception_adversary_0_act ((|landmark_0_dx| (_ FloatingPoint 8 24)) (|landmark_0_dy| (_ FloatingPoint 8 24)) (|landmark_1_dx| (_ FloatingPoint 8 24)) (|landmark_1_dy| (_ FloatingPoint 8 24)) (|agent_0_dx| (_ FloatingPoint 8 24)) (|agent_0_dy| (_ FloatingPoint 8 24)) (|agent_1_dx| (_ FloatingPoint 8 24)) (|agent_1_dy| (_ FloatingPoint 8 24))) Int
  0 ; stay, leaf 0
)

; agent_0, team defenders: 5 leaves; 0 stay, 1 left, 2 right, 3 down, 4 up
(define-fun physical_deception_agent_0_act ((|goal_dx| (_ FloatingPoint 8 24)) (|goal_dy| (_ FloatingPoint 8 24)) (|landmark_0_dx| (_ FloatingPoint 8 24)) (|landmark_0_dy| (_ FloatingPoint 8 24)) (|landmark_1_dx| (_ FloatingPoint 8 24)) (|landmark_1_dy| (_ FloatingPoint 8 24)) (|adversary_0_dx| (_ FloatingPoint 8 24)) (|adversary_0_dy| (_ FloatingPoint 8 24)) (|agent_1_dx| (_ FloatingPoint 8 24)) (|agent_1_dy| (_ FloatingPoint 8 24))) Int
  (ite (fp.leq |goal_dx| (fp #b0 #b01111011 #b10011001100110011001100)) ; node 0: 0.1
    (ite (fp.leq |landmark_0_dy| (fp #b0 #b00000000 #b00000000000000000000000)) ; node 1: 0
      1 ; left, leaf 2
      2 ; right, leaf 3
    )
    (ite (fp.leq |agent_1_dy| (fp #b1 #b01111101 #b01010101010101010101011)) ; node 4: -0.333333
      4 ; up, leaf 5
      (ite (fp.leq |landmark_0_dx| (fp #b0 #b11111110 #b11111111111111111111111)) ; node 6: 3.40282e+38
        0 ; stay, leaf 7
        0 ; stay, leaf 8
      )
    )
  )
)

; agent_1, team defenders: 4 leaves; 0 stay, 1 left, 2 right, 3 down, 4 up
(define-fun physical_deception_agent_1_act ((|goal_dx| (_ FloatingPoint 8 24)) (|goal_dy| (_ FloatingPoint 8 24)) (|landmark_0_dx| (_ FloatingPoint 8 24)) (|landmark_0_dy| (_ FloatingPoint 8 24)) (|landmark_1_dx| (_ FloatingPoint 8 24)) (|landmark_1_dy| (_ FloatingPoint 8 24)) (|adversary_0_dx| (_ FloatingPoint 8 24)) (|adversary_0_dy| (_ FloatingPoint 8 24)) (|agent_0_dx| (_ FloatingPoint 8 24)) (|agent_0_dy| (_ FloatingPoint 8 24))) Int
  (ite (fp.leq |landmark_1_dx| (fp #b1 #b01111010 #b10011001100110011001101)) ; node 0: -0.05
    1 ; left, leaf 1
    (ite (fp.leq |landmark_1_dx| (fp #b0 #b01111010 #b10011001100110011001101)) ; node 2: 0.05
      (ite (fp.leq |landmark_1_dy| (fp #b0 #b00000000 #b00000000000000000000000)) ; node 3: 0
        3 ; down, leaf 4
        4 ; up, leaf 5
      )
      2 ; right, leaf 6
    )
  )
)
