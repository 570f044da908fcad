# Draws the map of lab/study passivity --section map:
#   gnuplot -d -e "csv='passivity_map.csv'; out='map.svg'" lab/passivity/map.gp
set terminal svg size 900,360 font 'sans-serif,12' background 'white'
set output out
set datafile separator ','
set multiplot layout 1,3
set logscale y
set xrange [-0.5:5.5]
set yrange [40:4000]
set ytics (50, 100, 200, 400, 1000, 2000, 3000)
set xlabel 'latency (samples of 1 ms)'
set ylabel 'coupling (N/m)'
set key off
set grid ytics lc rgb '#dddddd'
limit = 1e-4
do for [b in "0.05 0.5 2"] {
  set title sprintf('device damping %s Ns/m', b)
  damping = real(b)
  plot csv using (($1 == damping && $5 <= limit) ? $2 : NaN):3 with points pt 7 ps 0.9 lc rgb '#0072b2', \
       csv using (($1 == damping && $5 > limit && $6 <= limit && $8 == 0) ? $2 : NaN):3 \
         with points pt 6 ps 0.9 lw 1.5 lc rgb '#e69f00', \
       csv using (($1 == damping && ($6 > limit || $8 != 0)) ? $2 : NaN):3 \
         with points pt 2 ps 0.9 lw 1.5 lc rgb '#000000', \
       (damping - 0.2) / (1e-3 * (0.5 + x)) with lines lw 1.5 dt 2 lc rgb '#555555'
}
unset multiplot
