; c float proof: is there an observation for which the emitted code and the tree of agent_0 act differently?
; unsat: there is none, among 2^320 observations
;
; profile     d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d
; made by     tests, hand-made, preset none, seed 0
;
; SMT-LIB 2, theories FloatingPoint and FixedSizeBitVectors. x0, x1, ... are the bits of the observation's numbers,
; f0, f1, ... their values as Float32.
; c0, c1, ... are the choices that the code makes, t0, t1, ... those of the tree.
(set-logic QF_BVFP)

(declare-const x0 (_ BitVec 32)) ; goal_dx
(define-fun f0 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) x0))
(declare-const x1 (_ BitVec 32)) ; goal_dy
(define-fun f1 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) x1))
(declare-const x2 (_ BitVec 32)) ; landmark_0_dx
(define-fun f2 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) x2))
(declare-const x3 (_ BitVec 32)) ; landmark_0_dy
(define-fun f3 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) x3))
(declare-const x4 (_ BitVec 32)) ; landmark_1_dx
(define-fun f4 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) x4))
(declare-const x5 (_ BitVec 32)) ; landmark_1_dy
(define-fun f5 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) x5))
(declare-const x6 (_ BitVec 32)) ; adversary_0_dx
(define-fun f6 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) x6))
(declare-const x7 (_ BitVec 32)) ; adversary_0_dy
(define-fun f7 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) x7))
(declare-const x8 (_ BitVec 32)) ; agent_1_dx
(define-fun f8 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) x8))
(declare-const x9 (_ BitVec 32)) ; agent_1_dy
(define-fun f9 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) x9))

(define-fun c0 () (_ BitVec 32) (ite (fp.leq f3 ((_ to_fp 8 24) #x00000000)) #x00000001 #x00000002))
(define-fun c1 () (_ BitVec 32) (ite (fp.leq f9 (fp.neg ((_ to_fp 8 24) #x3eaaaaab))) #x00000004 #x00000000))
(define-fun c2 () (_ BitVec 32) (ite (fp.leq f0 ((_ to_fp 8 24) #x3dcccccc)) c0 c1))

(define-fun t0 () (_ BitVec 32) (ite (fp.leq f9 ((_ to_fp 8 24) #xbeaaaaab)) #x00000004 #x00000000))
(define-fun t1 () (_ BitVec 32) (ite (fp.leq f3 ((_ to_fp 8 24) #x00000000)) #x00000001 #x00000002))
(define-fun t2 () (_ BitVec 32) (ite (fp.leq f0 ((_ to_fp 8 24) #x3dcccccc)) t1 t0))

(assert (distinct c2 t2))
(check-sat)
