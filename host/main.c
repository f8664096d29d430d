/* matrig: collects, simulates, compares and shows landings on a model landing-mat runway. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/commands/commands.h"
#include "host/help.h"
#include "host/output.h"
#include "host/store/store.h"

/* Of every command that writes a file (host/output.h). */
#define FORCE "  --force        write also over a file that is not what matrig wrote there\n"

static const struct command commands[] = {
    {"log", log_command, "--can LINK --serial LINK --db DB [--for S] [--live PORT] [--listen | --commands] [--elf F] [--page F] [--force] [--wait S]", "collect landings from a board",
     "  --can LINK     the board's CAN bus\n"
     "  --serial LINK  the board's serial port; either link may be left out\n"
     "  --db DB        campaign database, made when it does not exist\n"
     "  --for S        stop after S seconds; else at the end of the links, or on Ctrl-C\n"
     "  --live PORT    show it in a browser of this computer as it comes, arm and disarm there; see matrig live --help\n"
     "  --listen       send nothing: do not ask the board for its configuration\n"
     "  --commands     take arm [N] and disarm, a line each, from standard input; it does without when that is a terminal.\n"
     "                 Before it arms it asks, and sends when the next line is yes\n"
     "  --elf F        the image that the board runs: names the function of a processor fault\n"
     "  --page F       keep the report in F up to date: written beside the logging when a landing ends\n"
     "  --wait S       wait so long for a device that was unplugged or is down; else an hour\n"
     FORCE
     "When a landing ends its summary is printed; when its links fall silent in the middle, what came until then.\n"
     "Example: matrig log --can can:can0 --serial serial:/dev/ttyUSB0 --db campaign.db --page landing.html\n"
     "\n"
     "LINK is one of\n"
     "  unix:PATH      a socket on which an emulated board listens (waited for up to 5 s)\n"
     "  file:PATH      a recorded candump log (CAN) or recorded bytes (serial), as fast as it goes\n"
     "  paced:PATH     a candump log at the pace at which it was recorded\n"
     "  can:IFACE[:board]\n"
     "                 a CAN interface of this computer (SocketCAN), up, at 1 Mbit/s; with :board the board's messages alone\n"
     "  slcan:TTY[:BAUD]\n"
     "                 a LAWICEL adapter on a serial port, for CAN\n"
     "  serial:TTY[:BAUD|:find]\n"
     "                 a serial port, 8N1, 2000000 baud unless given; find: the usual rate at which a board is understood\n"
     "  pty:PATH       the pseudo-terminal of an emulated board (waited for likewise)\n"
     "Exit 3 when no board said hello: nothing came, the rate is another one, or the bus has errors alone; the message says which.\n"
     "Frames on CAN that are not the board's are counted and told, not obeyed.\n"
     "A device that goes away is waited for; what it lost is counted and said. What serial lost of a landing is filled from CAN.\n"
     "A campaign that another program holds, a slow and a full disk are waited for: a queue keeps 60 s of full links. What it cannot keep\n"
     "is counted and said. One that is moved, replaced, deleted or written over is saved as DB-saved-DATE.db beside, and gone on\n"
     "with; exit 3.\n"},
    {"live", live_command, "DB [--port PORT] | DB --terminal", "watch a board: a page in the browser, or this terminal",
     "  DB             campaign database that a running matrig log writes; followed, never written\n"
     "  --port PORT    serve the page there, at 127.0.0.1 or, with [::1]:PORT, at ::1; else 8473. 0: any port that is free\n"
     "  --terminal     show it in this terminal; when standard output is none, a line a second\n"
     "  --for S        stop after S seconds; else on Ctrl-C\n"
     "With --json: the state now, as one object, and no more. The page only watches: arm and disarm on that of matrig log --live,\n"
     "which holds the links. From another computer: ssh -L 8473:127.0.0.1:8473 HOST, and the address that was printed.\n"
     "Example: matrig log --can can:can0 --serial serial:/dev/ttyUSB0 --db campaign.db --live 8473\n"
     "         matrig live campaign.db --terminal\n"},
    {"board", board_command,
     "--serial LINK [--image FILE] | list | read N [-o FILE] [--force] [--db DB [--run RUN]] | free N | slow [--db DB] [--csv F] |\n"
     "                        config get|set|check [-o F] [--can LINK] [--db DB [--changed NOTE]] | runway [show|load F|forget] [-o F] |\n"
     "                        arm [LANDING] [--can LINK] | disarm [--can LINK] | health [--elf F] | self-test | reset",
     "a board: its firmware, black box, slow log, configuration, runway and health",
     "  --serial LINK  the board's serial port (see matrig log --help); the board must be idle\n"
     "  (no word)      the board, its firmware's version, commit and CRC, and whether the image is whole; --image FILE (.elf,\n"
     "                 .hex, .bin) compares it with a file. Exit 1 when it differs or is not whole\n"
     "  list           its records, and how much room there is\n"
     "  read N         record N: --db fills what is missing of its landing in a campaign database (the landing of the same\n"
     "                 board, number and arming, or RUN; made when there is none), -o keeps its pages in a file. When the link broke,\n"
     "                 the same command with -o goes on where it was. Exit 1 when a page cannot be read\n"
     "  free N         give its space back; nothing is ever overwritten that was not freed\n"
     "  slow           the slow log, a row a minute: --db fetches the rows that a campaign database lacks, --csv writes them to a file\n"
     "                 (without --db: all that the board holds)\n"
     "  config get     the configuration in force, as text; -o writes it to a file. --can LINK does as well as --serial\n"
     "  config set F   check F, show what it changes, send it, see that it is stored; refused from arm to done. A gain that has\n"
     "                 jumped (see matrig ready --help) since the campaign of --db, else since the board's, is refused, but for\n"
     "                 --changed NOTE --db DB, which keeps the note in the campaign\n"
     "  config check F check F alone, without a board; --db DB holds its gains against those that the campaign knows\n"
     "  runway         what the board's predictor knows of the runway: landings, joints, where it comes from; -o writes it to a file.\n"
     "                 load F gives the board that of a file, forget: nobody has measured it. Not from arm to done.\n"
     "                 matrig board --serial serial:/dev/ttyUSB0 runway -o before.txt\n"
     "  arm [LANDING]  arm it for a landing, numbered so; without a number, or with 0, it counts on. Over --can also while matrig\n"
     "                 log holds the same interface; over --serial when nobody else holds the port. Exit 2: the board refuses\n"
     "                 in its state, 3: not ready, try again, or no answer within 3 s\n"
     "                 matrig board --can can:can0 arm 7\n"
     "  disarm         back to idle, whatever is being recorded\n"
     "  health         restarts and their causes, memories, stack, CAN, faults, what a processor fault left behind (--elf F names\n"
     "                 its functions). Exit 1 when there is a fault\n"
     "  self-test      memories, reference, excitation, black box, warning lamp (it lights for 0.2 s). Exit 1 when one fails\n"
     "  reset          restart it\n"
     FORCE
     "Example: matrig board --serial serial:/dev/ttyUSB0 read 3 --db campaign.db\n"},
    {"flash", flash_command, "LINK IMAGE [--enter | --boot0] [--baud N] [--all] [--force] [--stay] [--erase-configuration]",
     "program a board through its chip's boot ROM",
     "  LINK           the board's serial port: serial:TTY, or pty:PATH of an emulated board. Its own rate is for the firmware;\n"
     "                 the boot ROM is spoken to with 8E1 at --baud. A port that does not do 2000000 baud: serial:TTY:115200,\n"
     "                 with --boot0 --stay\n"
     "  IMAGE          .elf, .hex or .bin of the firmware\n"
     "  --enter        the firmware runs: ask it to restart into the boot ROM (refused from arm to done)\n"
     "  --boot0        the boot ROM runs already, started with BOOT0 high. Without either: --enter when a board says hello\n"
     "                 within 2.5 s, else --boot0\n"
     "  --baud N       9600 to 460800 for the boot ROM, else 115200\n"
     "  --all          erase and write also what is there already\n"
     "  --force        flash although the board runs this image, or the image carries no header\n"
     "  --stay         do not start the firmware afterwards\n"
     "  --erase-configuration\n"
     "                 erase sectors 2 and 3 too; else they are never touched\n"
     "Only sectors that differ are erased. Every byte is read back. After a pulled cable the same command goes on where it was;\n"
     "until it is done the board starts into the boot ROM. Exit 1 when the board does not run what was flashed.\n"
     "Example: matrig flash serial:/dev/ttyUSB0 build/firmware/matrig.elf\n"},
    {"ready", ready_command, "DB --serial LINK [--can LINK] [--image FILE] [--expect-config CRC|FILE] [--room MB] [--changed T] | DB --serial LINK --walk [--for S] [--of KINDS]",
     "go or no-go before a landing, and the walk test",
     "  DB             campaign database, made when it does not exist; what was found is kept in it, with the landings of the next 12 h\n"
     "  --serial LINK  the board's serial port (see matrig log --help); the board must be idle, or done with a landing\n"
     "  --can LINK     listen to its CAN bus too\n"
     "  --image FILE   (.elf, .hex, .bin) the board must run this; else what it ran in the campaign's last landing\n"
     "  --expect-config CRC|FILE\n"
     "                 it must be configured so (a file: but for the revision, which config set raises); else as in the\n"
     "                 campaign's last landing\n"
     "  --room MB      so much of the disk must be free; else ten landings\n"
     "  --changed T    'd3: a longer rod', 'd3,t4: ...': what was changed of these channels. Without, it is no-go when the gain of a\n"
     "                 channel has jumped since the campaign's landings and checks (a tenth; half of another transducer, five times\n"
     "                 of another gage, by serial number), or its zero (0.25 in, 10 lb). Kept in the campaign (table readiness)\n"
     "Takes at most 20 s: readings at rest, shunt calibration, self-test (the warning lamp lights for 0.2 s). Exit 1: no-go.\n"
     "  --walk         walk along the rig: trip each switch, push at each transducer, pull at each gage, in order. Nothing is recorded.\n"
     "                 Names what did not answer and what answered in another's place. Exit 1 when there is any\n"
     "  --for S        the walk ends after S seconds; else after 600, when all have answered, or on Ctrl-C\n"
     "  --of KINDS     only these, of switches,transducers,gages\n"
     "Example: matrig ready campaign.db --serial serial:/dev/ttyUSB0 --can can:can0\n"},
    {"gages", gages_command, "zero [1|2] --serial LINK | shunt --serial LINK | bridge --excitation V --gain G ...",
     "zero and shunt calibration; pounds per code of a bridge",
     "  zero [1|2]     mean of a quarter of a second is the zero of all channels, of the transducers (1) or the gages (2), until\n"
     "                 reset. None is taken when one moves, is not valid, or is a gage under tension: exit 1\n"
     "  shunt          shunt calibration of the gages, a second; exit 1 when one is not good. matrig log on the board's CAN\n"
     "                 keeps it: the calibrations before and after a landing give its drift\n"
     "  --serial LINK  the board's serial port (see matrig log --help); the board must be idle, or done with a landing\n"
     "  bridge         what channel.unit_per_code and channel.shunt_lb should be, from\n"
     "    --excitation V, --gain G (of the amplifier), --gage-factor F, --area IN2 (of the band)\n"
     "    --arms N     1 one gage along the band (the default), 2 two along it, 2.6 and two across it\n"
     "    --modulus PSI (29e6), --ohm R of a gage (350), --shunt OHM. In pounds, as the configuration has it, also with --si\n"
     "Example: matrig gages zero 1 --serial serial:/dev/ttyUSB0; matrig gages bridge --excitation 5 --gain 200 --gage-factor 2.1 --area 0.0625\n"},
    {"survey", survey_command,
     "DB [--pattern standard|diagonal] [--edges left|both|none] [--new] [--closed IN] [--error IN] [--who W] [--note T]\n"
     "                         [--caliper LINK | --from CSV [--doubtful] | --end | --sheet F [--force] | --show | --list | --load LINK [--can]] [--survey N]",
     "gage points of the mat, read with a caliper: gaps, movement, in-plane bow, slack for the board",
     "  DB             campaign database, made when it does not exist. A survey that was not finished goes on\n"
     "  (nothing else) readings from the keyboard, or a caliper that types like one: a number and Enter. Each is on disk before\n"
     "                 the next is asked for. Words: s skip, u undo, b back, f forward, n TEXT note, q quit, ? help\n"
     "  --pattern P    standard: four lines of gage points and the stations of the left edge (181 readings). diagonal: stations\n"
     "                 along and across at all four lines, and seven 45 degree lines as well\n"
     "  --edges E      standard pattern: stations of the left edge (the default), of both, or of none\n"
     "  --new          begin another survey, though one is not finished\n"
     "  --closed IN    distance of gage points with all ten joints closed; else 33.5: what is beyond it is slack\n"
     "  --error IN     standard error of a reading; else 0.005\n"
     "  --caliper LINK a caliper on a serial line beside the keyboard: serial:TTY:BAUD\n"
     "  --from CSV     readings of a sheet. What a person would be asked about is taken with --doubtful only; exit 1 without\n"
     "  --sheet F      write the sheet: all places in walking order, and the last readings (-: standard output)\n"
     "  --end          end a partial survey as it is\n"
     "  --show         what survey N (else the newest) says: opening and closing per ten mats, movement, in-plane bow\n"
     "  --list         all surveys\n"
     "  --load LINK    give the board the slack and read it back; serial, or CAN when it is can:, slcan: or with --can. Exit 1\n"
     "                 when the board holds something else then\n"
     FORCE
     "A reading that is further from the last one than ten joints can do (10 x 0.036 in; a station: 1 in) is asked for again.\n"
     "With --si all lengths are millimetres. Example: matrig survey campaign.db --who jk; matrig survey campaign.db --load serial:/dev/ttyUSB0\n"},
    {"landing", landing_command,
     "DB [RUN] [--note T | --correct FIELD=VALUE | --observe wave|break|other ... | --withdraw N | --void | --unvoid] [--reason T] [--who W]",
     "notes, corrections and observations of landings, with their history",
     "  DB [RUN]       campaign database, and a landing in it; without RUN all are listed. Nothing is ever taken away: who said what,\n"
     "                 when, what it was before and why stays, and is shown\n"
     "  --note T       a note\n"
     "  --correct F=V  touchdown_ft (its station, used from then on), weight_lb (of the aircraft), pattern,\n"
     "                 modification, runway, series; needs --reason\n"
     "  --void         the landing does not count: report leaves it out and says so, compare and predict refuse it without their\n"
     "                 own --void. --unvoid takes that back. Both need --reason\n"
     "  --observe K    wave, break or other, with --station FT, --panels N, --height IN, --side left|right|centre|across,\n"
     "                 --form T (two-panel, end connector, ...), --at S (after touchdown), --note T\n"
     "  --withdraw N   observation N was a mistake; needs --reason\n"
     "  --who W        who says so; else the user\n"
     "Example: matrig landing campaign.db 5 --observe wave --station 88 --panels 2 --height 0.6 --side left --form two-panel\n"},
    {"series", series_command, "DB [NAME [--runway T] [--pattern T] [--modification T] [--notes T] [--who W]]",
     "series of landings: begin one, or list them",
     "  DB             campaign database\n"
     "  NAME           begin a series of this name: landings that are armed from now on belong to it\n"
     "Example: matrig series campaign.db standard-2 --pattern standard --runway 'relaid, bands tensioned'\n"},
    {"calibrate", calibrate_command,
     "CHANNEL (--serial LINK | --points F --config F) [--unit U] [-o F] [--force] [--sensor S] [--days N] [--known E] [--table]\n"
     "                         [--changed NOTE] [--db DB] |\n"
     "                         DB --recompute CONFIG [--series NAME | --run RUN] [--zeros] --reason T [--who W]",
     "a channel against known values; a corrected calibration for recorded landings",
     "  CHANNEL        d1 to d8, t1 to t14\n"
     "  --serial LINK  the board, idle: it is guided point by point, known value by known value\n"
     "  --points F     or from a file of VALUE,CODE rows, for the configuration of --config (matrig board config get). Its first line\n"
     "                 names the columns, and the unit of the values: mm,codes; a value may have a unit of its own: 12.7 mm,372.4.\n"
     "                 A name that is not understood wholly is refused (daN, inch/2, half inches)\n"
     "  --unit U       unit of values, where the file names none: in, mm, cm, m, ft of a transducer, lb, N, kN, kg of a gage\n"
     "  -o F           write the configuration with the new calibration; matrig board config set F gives it to the board\n"
     "  --sensor S     serial number of the sensor\n"
     "  --days N       until it expires; else 365\n"
     "  --known E      standard error of the known values, in or lb, or with its unit (0.05mm), common to all\n"
     "  --table        the values become a table of points (2 to 8); else a straight line\n"
     "  --changed NOTE the gain may be another than the last calibration's, because of this; else a jump is refused (exit 1): a tenth of\n"
     "                 the same sensor, half of another transducer, five times of another gage. The note stands in the file of -o\n"
     "  --db DB        hold the gain against what the campaign knows of its last board too, and keep the note of --changed there\n"
     "  --recompute C  give the landings of DB (of a series, or one) the calibration of configuration C. Readings come from the stored\n"
     "                 integers; the old values are kept (table recalibrations). Zeros of gages stay as measured, without --zeros\n"
     FORCE
     "Results are in inches and pounds, also with --si. Example: matrig calibrate d3 --serial serial:/dev/ttyUSB0 -o rig.cfg --sensor ET-17\n"},
    {"migrate", migrate_command, "DB [--check | --no-backup]", "bring a campaign of an older matrig forward",
     "  DB             campaign database. What writes to a campaign brings it forward by itself; what reads does not need to\n"
     "  --check        only say which version it has; exit 1 when it is an older one\n"
     "  --no-backup    keep no copy; else it stays beside it as it was, as DB.v2 and so on\n"
     "All of it happens or nothing, also when the power fails. Example: matrig migrate campaign.db --check\n"},
    {"sim", sim_command, "SCENE [--solver S] [--rtol R] [--dt H] [--csv F] [--force] [--no-prune] [--progress]", "run a mat scene",
     "  SCENE          scene file, JSON\n"
     "  --solver S     auto (the default) chooses and says why; event, implicit, cvode, rk4, rkgs, hamming for the\n"
     "                 planar models, fixed for the chain. Each answer is checked by a second run\n"
     "  --rtol R       tolerance of the solver; fixed: the error estimate allowed, of the largest movement\n"
     "  --dt H         step, s, of rk4 and fixed\n"
     "  --no-prune     integrate every mat all the time, also those at rest\n"
     "  --csv F        write the history of the mats in u_mats (or all): displacements, heights of their left ends\n"
     "  --progress     say how far the run is\n"
     FORCE
     "Ctrl-C ends a run and leaves what was computed (status interrupted, exit 5).\n"
     "Example: matrig sim host/scenes/consistent_fig3_11_12000.json --csv mats.csv\n"},
    {"error", error_command, "SCENE|--predictor [--plot F.svg] [--force]", "every solver's error against its run time",
     "  SCENE          scene file, JSON\n"
     "  --predictor    instead: the onboard predictor at each of its levels and several steps, on five landings: error against\n"
     "                 the fine chain, and cycles on the board.  matrig error --predictor --plot predictor.svg\n"
     "  --plot F.svg   draw error against run time. Errors are in ft, also with --si\n"
     FORCE
     "\n"
     "Each solver that the scene's model has runs over tolerances or steps, against a reference that two different\n"
     "methods agree on; when they do not, there is no table: exit 5.\n"
     "Example: matrig error host/scenes/consistent_fig3_7.json --plot error.svg\n"},
    {"campaign", campaign_command, "FILE [-j N] [--seeds N] [-o F.html|F.svg] [--force] [--check] [--no-prune]",
     "a series of landings on an ensemble of runways: which one survives",
     "  FILE           campaign file, JSON (host/campaign/README.md): runway, landings, modifications, seeds\n"
     "  -j N           runways at a time; else one per core. Results do not depend on it\n"
     "  --seeds N      that many seeds from the file's first one on, instead of the file's number\n"
     "  -o F           write a page (.html) or its picture alone (.svg)\n"
     "  --check        compute everything once more, every mat and both engines in every landing, and say what differs\n"
     "  --no-prune     integrate every mat all the time\n"
     FORCE
     "Results are distributions over the seeds: median and 5th to 95th percentile.\n"
     "Example: matrig campaign host/campaign/series/standard.json -o standard.html\n"},
    {"sweep", sweep_command,
     "FILE [-j N] [--shard i/n] [-o R.jsonl] [--timeout S] [--retry] [--force] | FILE --gather | FILE --slurm|--parallel [--shards N]",
     "studies over many scenes or campaigns: Cartesian, Latin hypercube, thresholds",
     "  FILE           the study, JSON (host/sweep/README.md): base scene or campaign, what is varied, what is wanted\n"
     "  -o R.jsonl     results, one JSON line a case; else FILE's name with .jsonl. The same command goes on where it was, after\n"
     "                 any kill; R.study.json is a copy of the study\n"
     "  -j N           cases at a time, each a process on one core; else as many as there are cores\n"
     "  --shard i/n    only every n-th case, from the i-th on, into R.i-of-n.jsonl. In a Slurm job array (SLURM_ARRAY_TASK_ID) that\n"
     "                 is done by itself; --shard /n takes i from there\n"
     "  --timeout S    give a case S seconds; else the study's timeout_s\n"
     "  --retry        do those again that failed\n"
     "  --gather [PART...]\n"
     "                 put the shards' results together in R.jsonl; exit 1 when cases are missing\n"
     "  --slurm        write and submit a job array (R.jsonl.slurm), wait for it, gather; --no-wait gathers in a job after it\n"
     "  --parallel     the same with GNU parallel (R.jsonl.parallel), -j shards at a time\n"
     "  --shards N     of them (16; four a core); --with 'OPTIONS' adds options for sbatch or parallel\n"
     "  --list         print ids and values of all cases, run nothing\n"
     FORCE
     "Exit 1 when cases are missing (stopped); cases that failed are recorded with their reason.\n"
     "\n"
     "Example: matrig sweep host/sweep/examples/threshold.json -o t.jsonl && matrig report t.jsonl\n"},
    {"compare", compare_command,
     "DB RUN [FILE] [--scene S] [--limits F] [--limit IN] [--seeds N] [--as-is] [-o F.svg|F.csv] [--force] [--void] | DB FILE [--series NAME] | DB --series NAME",
     "measured against simulated: a landing, or a series",
     "  DB RUN         campaign database and number of the landing in it, from 1\n"
     "  FILE           what it is compared with: a scene, or a campaign, whose runways are an ensemble that has a spread. Without\n"
     "                 RUN: all landings, in order; the runway is as each left it. Without FILE: the model runway\n"
     "  --scene S      the same as FILE\n"
     "  --series NAME  the landings of a series (matrig series) instead of all\n"
     "  --limits F     JSON; exit 1 when one fails: {\"channels\": {\"all\": {\"rms_in\": 0.05, \"correlation\": 0.99}, \"3\":\n"
     "                 {\"peak_in\": 0.1}}, \"zones\": {\"simulated\": {\"overlap\": 0.5}}, \"series\": {\"within\": 0.8}}\n"
     "  --limit IN     exit 1 when a channel's rms difference exceeds IN inches\n"
     "  --seeds N      as many of the campaign's runways; else as it says\n"
     "  --as-is        the scene with its own motion and gaps, not the landing's; both are aligned on switch edges\n"
     "  -o F           one landing: measured and simulated with their bands, a picture; .csv: as numbers, every millisecond\n"
     "  --void         also a landing that was voided (matrig landing)\n"
     FORCE
     "A sentence at its end says whether they agree, or which value differs most, by how much and where; only a limit that fails exits 1.\n"
     "Example: matrig compare campaign.db 5 --limits limits.json -o landing5.svg\n"
     "         matrig compare campaign.db host/campaign/series/standard.json\n"},
    {"fit", fit_command, "DB [RUN...] [--scene S] [--fit NAMES] [--prior NAME=V:E,...] [--draws N] [--seed N] [-j N] [--max-time S] [--plot F.svg] [-o F] [--force]",
     "gaps, resistance, friction, thrust share and stiffness from landings, with their errors",
     "  DB [RUN...]    campaign database and landings in it; else all whose motion is known\n"
     "  --scene S      scene file that gives the runway (model chain) and the priors' values; else the model runway\n"
     "  --fit NAMES    of gap,grit,f,share,KL: these are fitted, the others stay as they are; else all\n"
     "  --prior NAME=V:E,...\n"
     "                 what is known beforehand: value and standard error (lb, in, lb/ft). Else grit, KL and an unsurveyed gap are\n"
     "                 the scene's, known to 50 %, f to 20 %, share 1/12 to 15 %, a surveyed gap the survey's to 3 %\n"
     "  --draws N      simulated data sets a round, at least 60; else 300\n"
     "  --seed N       of what is drawn; else 1. The same seed gives the same answer\n"
     "  -j N           threads; else as many as processors\n"
     "  --max-time S   else 600; an answer that is not settled by then is given and said to be so\n"
     "  --plot F.svg   residual plots\n"
     "  -o F           the scene with the fitted values\n"
     FORCE
     "Example: matrig fit campaign.db 1 --fit grit,f --prior f=0.5:0.05 --plot fit.svg\n"},
    {"bundle", bundle_command, "DB RUN -o F [--force] [--elf F] [--scene F] [--without PART,...]", "one landing with all that a replay needs, in one file, to pass on",
     "  DB RUN         campaign database and number of the landing in it, from 1\n"
     "  -o F           where to write it: a database in which the landing is RUN 1, with page, candump log, configuration,\n"
     "                 scene and firmware image as an archive (sqlite3 F -Ax) and SHA-256 of each; at most 10 MB\n"
     "  --elf F        the image that recorded it, another one is refused; else the one that came with matrig\n"
     "  --scene F      when the landing was not compared; else the model runway\n"
     "  --without P    parts to leave out, with commas: page, candump, configuration, scene, firmware\n"
     FORCE
     "Example: matrig bundle campaign.db 5 -o landing5.bundle\n"},
    {"replay", replay_command, "DB RUN [--speed max|real] [--elf F] [--board F] [--exact] | BUNDLE [--verify] [--save DIR [--force]]",
     "a recorded landing through the firmware again, and whether it says the same",
     "  DB RUN         campaign database and number of the landing in it, from 1\n"
     "  BUNDLE         a file of matrig bundle: every part is checked, then it is replayed with the image in it\n"
     "  --verify       check the bundle alone; exit 4 when anything is not as it was made\n"
     "  --save DIR     write those files in the bundle that are whole into this folder, also of a damaged one\n"
     "  --speed S      max (the default), or real: by the wall clock\n"
     "  --elf F        firmware image; else the bundle's, or the one that came with matrig\n"
     "  --board F      the emulated board; else matrig-board beside matrig\n"
     "  --exact        every field must be equal, also when another image recorded the landing; else such a landing\n"
     "                 is compared within tolerances, which the output states\n"
     FORCE
     "Exit 1 when anything differs.\n"
     "Example: matrig replay landing5.bundle\n"},
    {"predict", predict_command, "DB RUN... [--void]", "the predictor of zones and warnings on recorded landings",
     "  DB RUN         campaign database and number of the landing in it, from 1; of several, in order, each begins with\n"
     "                 what the joints have become in the one before, and with the segments surveyed since:\n"
     "                 matrig predict campaign.db 1 2 3 4 5\n"
     "A row for each change: longest closed zone ahead of the wheel with its 95 % intervals, longest zone that the\n"
     "wheel will meet or push together before it stops, compression ahead, verdict. It knows at each time what the\n"
     "board knew then: edges so far, readings so far, the survey, and, where the record has it, the runway that the board\n"
     "was armed with (of several landings for the first). Times are seconds after touchdown by the board's clock, at the\n"
     "beginning of the block that decided, as in log, report and make series.\n"
     "  --void         also of a landing that was voided\n"
     "Example: matrig predict campaign.db 5\n"},
    {"report", report_command, "DB [-o F.html] [--force] [--run RUN] [--film FOLDER] [--void] | SWEEP.jsonl [-o F.html]", "the campaign, or a sweep, as one page, with plots",
     "  DB             campaign database\n"
     "  SWEEP.jsonl    results of matrig sweep\n"
     "  -o F           where to write the page; else the name of what it shows with .html\n"
     "  --run RUN      of this landing alone\n"
     "  --film FOLDER  pictures of the film (JPEG, PNG; the last number in a name is the frame's), a folder RUN for each landing\n"
     "  --void         with the landings that were voided (matrig landing)\n"
     FORCE
     "A PDF of it is printed by the browser. Example: matrig report campaign.db -o report.html\n"},
    {"export", export_command, "DB RUN --format csv|candump|frames|mdf4 [-o F] [--force]", "one landing for other tools",
     "  DB RUN         campaign database and number of the landing in it, from 1\n"
     "  --format csv   time, gear position, displacements and tensions at 1 kHz\n"
     "  --format candump\n"
     "                 the CAN frames as `candump -L` writes them, stamped with the time of day by the board's clock;\n"
     "                 where that is not known, with board time plus 1000000000 s, a date in 2001, and a note says why\n"
     "  --format frames\n"
     "                 each frame of the camera's film: time, where the gear stood and how well that is known\n"
     "  --format mdf4  ASAM MDF 4.10: readings and gear at 1 kHz with units and what is not valid, CAN frames as bus logging\n"
     "                 with the DBC attached\n"
     "  -o F           where to write; else standard output\n"
     FORCE
     "Example: matrig export campaign.db 5 --format csv -o landing5.csv\n"},
    {"import", import_command, "DB FILE [--map M.json] [--like RUN] [--interface NAME] [--again]", "logs, and other instruments' readings, into the campaign",
     "  DB             campaign database, made when it does not exist\n"
     "  FILE           a log that candump -L wrote of a matrig board: its landings are taken in as if they had been logged.\n"
     "                 Or a table that matrig export --format csv wrote. With --map:\n"
     "  --map M.json   a table of another instrument (CSV), or its frames in a candump log, becomes a landing. M says what is what:\n"
     "                 {\"separator\": \";\", \"decimal\": \",\", \"header_lines\": 2, \"comment\": \"#\", \"missing\": [\"---\"],\n"
     "                  \"time\": {\"column\": \"Zeit\", \"unit\": \"ms\", \"shift_s\": 0.25},\n"
     "                  \"align\": {\"column\": \"Trigger\", \"threshold\": 2.5, \"edge\": \"falling\", \"switch\": 3},\n"
     "                  \"channels\": [{\"column\": \"Weg 1\", \"channel\": \"d1\", \"unit\": \"mm\", \"scale\": 2.5, \"offset\": -1, \"station_ft\": 40,\n"
     "                                \"error\": 0.05}]}\n"
     "                 header_lines: how many stand above the rows, blank lines counted, comments not. column: its name, or its number\n"
     "                 from 1. channel: d1 to d8 (in, mm, cm, m, ft), t1 to t14 (lb, N, kN, kip), gear (ft, m,\n"
     "                 in, mm; where it passes the switches are edges), switch1 to switch64 (with threshold and edge). value = (what stands\n"
     "                 there * scale + offset) in unit; error: its standard error. Times: s, ms, us, min. Also touchdown_ft,\n"
     "                 switch_error_ft, gap_s (more is missing data; else 1.5 times the usual), last_line_open (true: the last line needs\n"
     "                 no newline), note. For frames, in place of column: \"signal\": \"Message.Signal\" of the file that \"dbc\" names, or\n"
     "                 \"id\": \"0x321\", \"start_bit\", \"bits\", \"signed\", \"float\", \"byte_order\"\n"
     "  --like RUN     it is of the same landing as RUN: gear, switches, survey and stations are RUN's, and time 0 is RUN's touchdown,\n"
     "                 or the edge that align names is RUN's\n"
     "  --interface NAME\n"
     "                 take the frames of this bus of the log; else those of its first frame's\n"
     "  --again        though the same file was imported before\n"
     "A damaged file gives a verdict (complete, truncated at, malformed at: line and column), exit 4, and what is good of it is kept.\n"
     "Example: matrig import campaign.db candump-2026-05-04.log\n"
     "         matrig import campaign.db lvdt.csv --map lvdt.json --like 5\n"},
    {"dbc", dbc_command, "[-o F] [--force]", "the CAN messages as a Vector DBC file",
     "  -o F           where to write; else standard output\n"
     FORCE
     "Example: matrig dbc -o matrig.dbc\n"},
    {"scale", scale_command, "[NAME=VALUE... | SCENE | CAMPAIGN] [--to model|prototype] [--n N] [--keep density|modulus] [--lay DEG] [-o F] [--force]",
     "quantities, scenes and campaigns between model and prototype",
     "  NAME=VALUE     a quantity, by name or symbol; without any, all ratios are listed. Dimensionless terms that the\n"
     "                 given quantities make up are shown for both sides\n"
     "  SCENE          scene file, JSON: every key is scaled, defaults that scale are written out\n"
     "  CAMPAIGN       campaign file (it has landings): runway, aircraft, landings and what they apply, its scene inside\n"
     "  --to SIDE      prototype (the default: what is given is the model's) or model\n"
     "  --n N          prototype length / model length; else 7\n"
     "  --keep density the 1/7 model's rule: forces by n^3 (the default)\n"
     "  --keep modulus the pilot model's rule: forces by n^2\n"
     "  --lay DEG      turn the joints of a standard pattern so far from straight across: the keys of a strip along the runway,\n"
     "                 N so that it stays as long; scales only with --to or --n. Sliding (lay_slide, lay_mu) is yours to add\n"
     "  -o F           where to write the scene; else standard output\n"
     FORCE
     "Units are those of the scene keys (ft, lb, slug, s), also with --si.\n"
     "Example: matrig scale F=108 v=35.5; matrig scale host/scenes/model_runway.json -o prototype.json\n"
     "  matrig scale host/campaign/series/rig.json --lay 45 -o diagonal.json\n"},
    {"params", params_command, "READINGS [-o F] [--force]", "readings of simple tests to scene parameters",
     "  READINGS       JSON with any of these tests; a reading is a number, {\"value\": V, \"error\": E} or\n"
     "                 {\"readings\": [...], \"error\": E}, with standard errors\n"
     "                 inertia     weight_lb, spacing_ft and cord_ft of two cords, period_s of turning: W and I\n"
     "                 tension     joint_in, slope_lb_in_in; or joint_in, strip_in, lists force_lb, stretch_in: KL\n"
     "                 hinge       lists angle_deg, moment_ft_lb [, strip_in, joint_in]: KT and TAD_deg\n"
     "                             (readings within the free travel are found and left out; three or more must lie beyond)\n"
     "                 pull        pull_lb, weight_lb: f\n"
     "                 deflection  load_lb, deflection_in [, mats]: KV\n"
     "  -o F           write the parameters as the beginning of a scene\n"
     FORCE
     "Units are those of the scene keys (ft, lb, slug, s), also with --si.\n"
     "Example: matrig params readings.json -o scene.json\n"},
    {"bands", bands_command, "[NAME=VALUE[UNIT]...] [--design-only] [--passes N] [--strict]",
     "design restraining bands by Appendix C, and check them in the model",
     "  NAME=VALUE     what is not given is the report's example (a number alone is in the unit named here):\n"
     "                 weight (lb), deceleration (ft/s2), bands, width and thickness (in) or area (in2), yield, modulus\n"
     "                 (psi), mat (lb), friction, held (mats that act against a connection), every (rows from rivet to\n"
     "                 rivet), row (ft), gear (ft, width of influence), length (ft between springs; else the longest),\n"
     "                 spring (lb/ft), at (0 to 1, where dT is worked out), tension (lb, T0), grip (lb, of a connection),\n"
     "                 speed (ft/s, in the model)\n"
     "  UNIT           lb kip N kN, ft in m mm, ft/s mph m/s, ft/s2 g m/s2, psi ksi MPa GPa, lb/ft lb/in kip/in N/mm,\n"
     "                 in2 ft2 mm2\n"
     "  --design-only  leave the model out\n"
     "  --passes N     how often the aircraft passes in the model; else 2\n"
     "  --strict       exit 1 for what only the model finds, too\n"
     "Exit 1 when the band goes slack or yields by theory. What the model says otherwise is a warning: the report's own example has\n"
     "its bands at the theory's limit, and R goes from rivet to rivet in knocks. Example:\n"
     "  matrig bands weight=480kip deceleration=0.5g bands=4 width=6in thickness=0.375in yield=50ksi\n"},
};

#define COMMAND_COUNT (sizeof commands / sizeof commands[0])

static const struct command_table table = {commands, COMMAND_COUNT};

static int fail_usage(const char *what, const char *where)
{
    struct error error = {0};
    error_set(&error, MR_USAGE, "%s: '%s'; see matrig --help", what, where);
    return cli_fail(&error);
}

/* What was printed must have arrived, or the exit code says so. */
static int finish_output(void)
{
    struct error error = {0};
    struct output standard;
    output_begin(&standard, NULL, false, &error);
    return output_end(&standard, &error) == MR_OK ? 0 : cli_fail(&error);
}

static void tell_migration(const char *line)
{
    fprintf(stderr, "matrig: %s\n", line);
}

int main(int argc, char **argv)
{
    struct cli cli = {0};
    int i = 1;
    for (; i < argc && argv[i][0] == '-'; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            help_overview(&table);
            return finish_output();
        } else if (strcmp(argv[i], "--version") == 0) {
            help_version(&cli);
            return finish_output();
        } else if (strcmp(argv[i], "--json") == 0) {
            cli.json = true;
        } else if (strcmp(argv[i], "--quiet") == 0) {
            cli.quiet = true;
        } else if (strcmp(argv[i], "--si") == 0) {
            cli.si = true;
        } else {
            return fail_usage("unknown option", argv[i]);
        }
    }
    if (i == argc)
        return fail_usage("no command given", "matrig");
    if (strcmp(argv[i], "help") == 0) {
        int exit_code = help_words(argc - i, argv + i, &table, &cli);
        return exit_code ? exit_code : finish_output();
    }
    store_on_migration(cli.quiet ? NULL : tell_migration);
    for (size_t c = 0; c < COMMAND_COUNT; c++) {
        if (strcmp(argv[i], commands[c].name) != 0)
            continue;
        for (int k = i + 1; k < argc; k++) {
            if (strcmp(argv[k], "--help") == 0 || strcmp(argv[k], "-h") == 0) {
                help_command(&commands[c]);
                return finish_output();
            }
        }
        int exit_code = commands[c].run(argc - i, argv + i, &cli);
        return exit_code ? exit_code : finish_output();
    }
    return fail_usage("unknown command", argv[i]);
}
