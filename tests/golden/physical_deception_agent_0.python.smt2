; python double proof: is there an observation for which the emitted code and the tree of agent_0 act differently?
; unsat: there is none, among 2^640 observations
;
; profile     d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d
; made by     tests, hand-made, preset none, seed 0
;
; SMT-LIB 2, theories FloatingPoint and FixedSizeBitVectors. x0, x1, ... are the bits of the observation's numbers,
; f0, f1, ... their values as Float32, rounded once from the doubles d0, d1, ....
; p0, p1, ... are the choices that the code makes, t0, t1, ... those of the tree.
(set-logic QF_BVFP)

(declare-const x0 (_ BitVec 64)) ; goal_dx
(define-fun d0 () (_ FloatingPoint 11 53) ((_ to_fp 11 53) x0))
(define-fun f0 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) RNE d0))
(declare-const x1 (_ BitVec 64)) ; goal_dy
(define-fun d1 () (_ FloatingPoint 11 53) ((_ to_fp 11 53) x1))
(define-fun f1 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) RNE d1))
(declare-const x2 (_ BitVec 64)) ; landmark_0_dx
(define-fun d2 () (_ FloatingPoint 11 53) ((_ to_fp 11 53) x2))
(define-fun f2 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) RNE d2))
(declare-const x3 (_ BitVec 64)) ; landmark_0_dy
(define-fun d3 () (_ FloatingPoint 11 53) ((_ to_fp 11 53) x3))
(define-fun f3 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) RNE d3))
(declare-const x4 (_ BitVec 64)) ; landmark_1_dx
(define-fun d4 () (_ FloatingPoint 11 53) ((_ to_fp 11 53) x4))
(define-fun f4 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) RNE d4))
(declare-const x5 (_ BitVec 64)) ; landmark_1_dy
(define-fun d5 () (_ FloatingPoint 11 53) ((_ to_fp 11 53) x5))
(define-fun f5 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) RNE d5))
(declare-const x6 (_ BitVec 64)) ; adversary_0_dx
(define-fun d6 () (_ FloatingPoint 11 53) ((_ to_fp 11 53) x6))
(define-fun f6 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) RNE d6))
(declare-const x7 (_ BitVec 64)) ; adversary_0_dy
(define-fun d7 () (_ FloatingPoint 11 53) ((_ to_fp 11 53) x7))
(define-fun f7 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) RNE d7))
(declare-const x8 (_ BitVec 64)) ; agent_1_dx
(define-fun d8 () (_ FloatingPoint 11 53) ((_ to_fp 11 53) x8))
(define-fun f8 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) RNE d8))
(declare-const x9 (_ BitVec 64)) ; agent_1_dy
(define-fun d9 () (_ FloatingPoint 11 53) ((_ to_fp 11 53) x9))
(define-fun f9 () (_ FloatingPoint 8 24) ((_ to_fp 8 24) RNE d9))

(define-fun p0 () (_ BitVec 32) (ite (fp.leq d3 ((_ to_fp 11 53) #x3690000000000000)) #x00000001 #x00000002))
(define-fun p1 () (_ BitVec 32) (ite (fp.leq d9 ((_ to_fp 11 53) #xbfd5555550000001)) #x00000004 #x00000000))
(define-fun p2 () (_ BitVec 32) (ite (fp.leq d0 ((_ to_fp 11 53) #x3fb9999990000000)) p0 p1))

(define-fun t0 () (_ BitVec 32) (ite (fp.leq f9 ((_ to_fp 8 24) #xbeaaaaab)) #x00000004 #x00000000))
(define-fun t1 () (_ BitVec 32) (ite (fp.leq f3 ((_ to_fp 8 24) #x00000000)) #x00000001 #x00000002))
(define-fun t2 () (_ BitVec 32) (ite (fp.leq f0 ((_ to_fp 8 24) #x3dcccccc)) t1 t0))

(assert (distinct p2 t2))
(check-sat)
