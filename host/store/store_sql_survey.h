/* Statements of host/store/store_survey.c and store_journal.c; store_sql.h has the others. */
#ifndef MATRIG_HOST_STORE_STORE_SQL_SURVEY_H
#define MATRIG_HOST_STORE_STORE_SQL_SURVEY_H

#define STORE_SURVEY_STATEMENTS(X)                                                                                    \
    X(GAGE_SURVEY_ADD, "itttrrt",                                                                                     \
      "INSERT INTO gage_surveys(made_us, pattern, edges, who, error_in, closed_in, note) VALUES(?,?,?,?,?,?,?)")      \
    X(GAGE_SURVEY_END, "ii", "UPDATE gage_surveys SET ended_us=? WHERE id=?")                                         \
    X(GAGE_SURVEYS, "",                                                                                               \
      "SELECT s.id, s.made_us, s.ended_us, s.pattern, s.edges, s.who, s.error_in, s.closed_in, s.note,"               \
      " (SELECT max(id) FROM landings WHERE armed_us<=s.made_us) FROM gage_surveys AS s ORDER BY s.id")               \
    X(GAGE_READING_ADD, "itiiriiitt",                                                                                 \
      "INSERT INTO gage_readings(survey, kind, line, place, value_in, skipped, confirmed, taken_us, source, note)"    \
      " VALUES(?,?,?,?,?,?,?,?,?,?)")                                                                                 \
    X(GAGE_READINGS, "i",                                                                                             \
      "SELECT kind, line, place, value_in, skipped, confirmed, taken_us, source, note FROM gage_readings"             \
      " WHERE survey=? ORDER BY id")                                                                                  \
    X(GAGE_LOAD_ADD, "iiti", "INSERT INTO gage_loads(survey, made_us, link, segments) VALUES(?,?,?,?)")               \
    X(GAGE_LOAD_GET, "i", "SELECT made_us, link, segments FROM gage_loads WHERE survey=? ORDER BY id DESC LIMIT 1")   \
    X(CHANGE_ADD, "iittttt",                                                                                          \
      "INSERT INTO landing_changes(landing, made_us, who, field, value, reason, was) VALUES(?,?,?,?,?,?,?)")          \
    X(CHANGES, "i", "SELECT landing, made_us, who, field, was, value, reason FROM landing_changes WHERE landing=? ORDER BY id") \
    X(CHANGE_NEWEST, "it",                                                                                            \
      "SELECT value, reason FROM landing_changes WHERE landing=? AND field=? ORDER BY id DESC LIMIT 1")               \
    X(OBSERVATION_ADD, "iitttriirrtt",                                                                                \
      "INSERT INTO observations(landing, made_us, who, kind, side, station_ft, panels, withdraws, height_in, time_s," \
      " form, note) VALUES(?,?,?,?,?,?,?,?,?,?,?,?)")                                                                 \
    X(OBSERVATIONS, "i",                                                                                              \
      "SELECT o.id, o.made_us, o.who, o.kind, o.side, o.station_ft, o.panels, o.height_in, o.time_s, o.form, o.note," \
      " EXISTS(SELECT 1 FROM observations AS w WHERE w.withdraws=o.id) FROM observations AS o"                        \
      " WHERE landing=? AND withdraws IS NULL ORDER BY id")                                                           \
    X(RECALIBRATION_ADD, "iiirritt",                                                                                  \
      "INSERT INTO recalibrations(landing, idx, item, was, value, made_us, who, reason) VALUES(?,?,?,?,?,?,?,?)")     \
    X(RECALIBRATED, "i", "SELECT count(*) FROM recalibrations WHERE landing=?")                                       \
    X(SERIES_ADD, "itttttt",                                                                                          \
      "INSERT INTO series(made_us, who, name, runway, pattern, modification, notes) VALUES(?,?,?,?,?,?,?)")           \
    X(SERIES, "", "SELECT id, made_us, who, name, runway, pattern, modification, notes FROM series ORDER BY id")

#endif
