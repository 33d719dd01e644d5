%
(A clamp plate, 60 by 40 mm. It uses every word that discreta machine reads.)
N10 G21 G17 G90 G40 G49 G80 G94 G54 (millimetres, XY, absolute)
N20 G64 ; the machine stops exactly at every block, whatever this asks for
N30 T1 M6 S12000 M3
N40 M8
N50 G43 H1

(the outline, once round, 2 mm deep: lines, corners by R and by I and J)
N100 G0 X-10 Y-8 Z5
N110 G1 Z-2 F200
N120 G1 Y0 F600
N130 X0
N140 X52
N150 G3 X60 Y8 R8
N160 G1 Y28
N170 G3 X48 Y40 I-12 J0
N180 G1 X20
N190 G2 X12 Y32 R8            (an inner corner)
N200 G3 X0 Y20 R-12           (a lug: three quarters of a circle)
N210 G1 Y0
N220 G0 Z5

(a round pocket: down a helix of two turns, then full circles outwards)
N300 G0 X40 Y20
N310 G1 Z0.5 F300
N320 G3 X40 Y20 Z-3 I-2 P2 F250
N330 G3 I-2 F500
N340 G1 X42.5
N350 G3 I-4.5
N360 G1 X45
N370 G3 I-7
N380 G0 Z5

(a short wave, in increments)
#1 = 0                        (the angle)
#<r> = 3.5
N400 G0 X[16+#<r>] Y14
N410 G1 Z-1 F200
N420 G91 G1 X1.25 Y0.7 F450   (increments)
N430 X1.25 Y-0.7
N440 X1.25 Y0.7
N450 X1.25 Y-0.7
N460 G90

(a trough across the plate: arcs in the planes XZ and YZ)
N500 G0 Z3
N510 G0 X8 Y10
N520 G18 G3 X18 Z3 I5 K0 F350
N530 G1 Y11.5
N540 G2 X8 Z3 R6
N550 G19 G3 Y16 Z3 J2.25 K1
N560 G17

(holes in a coordinate system of their own, in inches, in inverse time)
N600 G10 L2 P2 X50 Y10 Z0
N610 G55 G20
N620 G0 X0 Y0 Z0.1
N630 G93 G1 Z-0.1 F30         (two seconds)
N640 G2 X0.1 Y0 I0.05 J0 F60  (one second)
N650 X0 Y0 I-0.05 J0 F60
N660 G94 G1 Z0.1 F12
N670 G4 P0.25
N680 G21 G54

(this point is called 0, 0 for a while)
N700 G92 X0 Y0
N710 G1 X-20 Y[10*SIN[30]] F900
/N720 G4 P0.5 (left out with --block-delete)
N730 G92.1
N740 G90.1 G2 X35 Y20 I30 J20 F800 (an absolute centre)
N750 G91.1
N760 M9 M5
N770 G53 G0 Z8
N780 G28
N790 M30
%
