// What the board did, as JSON lines; `t_s` is CLOCK_MONOTONIC, as Python's time.monotonic().
#pragma once

#include <stdarg.h>
#include <stdio.h>

class Log {
public:
    explicit Log(FILE *file) : file_(file) {}

    // Write one line; `fields` is JSON of one field or more, as for printf.
    __attribute__((format(printf, 4, 5))) void say(double now_s, const char *event,
                                                   const char *fields, ...) {
        begin(now_s, event);
        fputs(", ", file_);
        va_list values;
        va_start(values, fields);
        vfprintf(file_, fields, values);
        va_end(values);
        end();
    }

    void say(double now_s, const char *event) {
        begin(now_s, event);
        end();
    }

private:
    void begin(double now_s, const char *event) {
        fprintf(file_, "{\"t_s\": %.6f, \"event\": \"%s\"", now_s, event);
    }

    void end() {
        fputs("}\n", file_);
        fflush(file_);
    }

    FILE *file_;
};
