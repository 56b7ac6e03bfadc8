"""What was tried with FMUs made for it and is right: a line for the page, and the test that shows it."""

TRIED = (
    (
        "start values of every type, arrays of any rank among them",
        "orchestration/test_foreign_types.py::test_start_values_come_from_the_file",
    ),
    (
        "values of every numeric type on their way from an input to an output",
        "orchestration/test_foreign_types.py::test_values_of_every_numeric_type_arrive",
    ),
    (
        "matrices are the same in both versions of FMI, row by row",
        "orchestration/test_fmu_files.py::test_ports_are_the_same_arrays_in_both_versions",
    ),
    (
        "enumerations, by the names of their items and by numbers",
        "orchestration/test_foreign_types.py::test_enumerations_by_name_and_by_number",
    ),
    ("texts", "orchestration/test_foreign_types.py::test_texts"),
    ("binary values, also empty ones", "orchestration/test_foreign_types.py::test_an_empty_binary_value"),
    (
        "arrays of other sizes, set before the run from Python",
        "orchestration/test_foreign_types.py::test_structural_parameters_can_be_set",
    ),
    (
        "and after the system is wired",
        "orchestration/test_foreign_types.py::test_structural_parameters_can_be_set_later",
    ),
    (
        "structural parameters that are valid only together",
        "orchestration/test_structural_parameters.py::test_two_that_are_valid_only_together",
    ),
    (
        "structural parameters that are no sizes, of any type",
        "orchestration/test_structural_parameters.py::test_those_that_are_no_sizes",
    ),
    ("arrays of size 0", "orchestration/test_structural_parameters.py::test_arrays_of_size_0"),
    (
        "several names of a variable, wired by any of them",
        "orchestration/test_aliases.py::test_what_goes_through_another_name_is_there_at_once",
    ),
    (
        "algebraic loops through them",
        "orchestration/test_aliases.py::test_a_loop_through_another_name_is_seen",
    ),
    (
        "clocks: constant, fixed, tunable, changing and countdown, decimal and as fractions, at their instants",
        "orchestration/test_foreign.py::test_clocks_of_every_kind_tick_at_their_instants",
    ),
    (
        "ticks that do not depend on the communication step",
        "orchestration/test_foreign.py::test_ticks_do_not_depend_on_the_communication_step",
    ),
    (
        "clocks and events in a saved state",
        "orchestration/test_foreign.py::test_a_saved_state_holds_clocks_and_events_too",
    ),
    (
        "a run with clocks that is gone on with from a checkpoint, to the last bit",
        "orchestration/test_foreign.py::test_a_checkpoint_is_gone_on_from_to_the_last_bit",
    ),
    (
        "an output clock that triggers another component at once",
        "orchestration/test_foreign.py::test_an_output_clock_triggers_another_component_at_once",
    ),
    ("early return", "orchestration/test_foreign.py::test_a_step_returned_from_early_is_gone_on_with"),
    (
        "discarded steps, taken in smaller ones",
        "orchestration/test_foreign.py::test_discarded_steps_are_taken_in_smaller_ones_from_the_saved_state",
    ),
    (
        "FMUs that may not be read after they were set",
        "orchestration/test_strict_slaves.py::test_what_depends_on_no_input_is_fetched_first",
    ),
    ("asynchronous steps (FMI 2.0)", "orchestration/test_foreign.py::test_asynchronous_steps_are_waited_for"),
    (
        "state events inside a step, at the time that the FMU found",
        "orchestration/test_foreign.py::test_state_events_inside_a_step_are_where_the_fmu_found_them",
    ),
    (
        "a time event and a state event at once",
        "orchestration/test_state_events.py::test_a_time_event_and_a_state_event_at_once",
    ),
    (
        "simultaneous state events in several components",
        "orchestration/test_state_events.py::test_simultaneous_events_are_one",
    ),
    (
        "crossings there and back within a step",
        "orchestration/test_state_events.py::test_crossings_there_and_back_within_a_step",
    ),
    (
        "an end that a component asks for, at the end of a step and in its midst",
        "orchestration/test_end_requested.py::test_in_the_midst_of_a_step",
    ),
    (
        "one instance per process, by a library for each",
        "orchestration/test_foreign.py::test_one_instance_per_library",
    ),
    ("FMI 2.0 and 3.0 in one SSP", "ssp/test_reading.py::TestArrays::test_of_fmi_2_and_3_go_together"),
    ("FMI 2.0 components in SSP 2.0", "ssp/test_round_trip.py::test_ssp_2_with_components_of_fmi_2"),
    (
        "transformations on a way through several systems",
        "ssp/test_reading.py::TestNestedSystems::test_transformations_on_the_way_follow_each_other",
    ),
    ("patches and minor versions of FMI 3", "standards/test_versions.py::test_a_version_3_runs_as_3_0"),
    (
        "defaults that stand in declared types",
        "standards/test_declared_types.py::test_every_attribute_of_a_type_is_the_default",
    ),
    ("inverse display units", "standards/test_display_units.py::test_a_value_in_a_display_unit"),
)
