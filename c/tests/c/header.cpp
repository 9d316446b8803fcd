// The header in C++: with C linkage, types and codes usable. c/check compiles, links and runs it.

#include "ironout.h"
#include "ironout.h"

int main()
{
    static ironout_session session;
    static const ironout_sensor sensor = { { 0.15f, 0.15f, 0.15f }, 100.0f, 0.0f };
    const ironout_error before = ironout_session_accept(&session, nullptr);
    const ironout_error begun = ironout_session_init(&session, &sensor);
    return before == IRONOUT_NOT_INITIALISED && begun == IRONOUT_OK ? 0 : 1;
}
