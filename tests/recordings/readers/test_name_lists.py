"""Names for commands of bare numbers, from the lists that their controllers publish."""

import pytest

from estexp_jax.recordings.readers.name_lists import NameLists

TOPIC = "/arm_controller/commands"
COLUMNS = [f"{TOPIC}.data[{k}]" for k in range(3)]
NAMES, OTHER = ["elbow", "base", "wrist"], ["base", "elbow", "wrist"]
STATES = ("/joint_states", {"name": OTHER, "position": [0.0, 1.0, 2.0]})


def _parameters(node, name, names, kind="new_parameters"):
    return "/parameter_events", {"node": node, kind: [{"name": name, "value": {"string_array_value": names}}]}


def _layout(labels):
    return TOPIC, {"layout": {"dim": [{"label": label, "size": 1} for label in labels]}, "data": [0.0, 1.0, 2.0]}


@pytest.mark.parametrize(
    ("messages", "found"),
    [
        ([STATES], None),
        ([STATES, ("/arm_controller/controller_state", {"joint_names": NAMES, "error": {"positions": [0.0]}})], NAMES),
        ([STATES, _parameters("/arm_controller", "joints", NAMES)], NAMES),
        ([_parameters("/arm_controller", "joints", NAMES, "changed_parameters")], NAMES),
        ([_parameters("/leg_controller", "joints", NAMES)], None),
        ([_parameters("/arm_controller", "joints", NAMES[:2])], None),
        ([_parameters("/arm_controller", "interfaces", NAMES)], None),
        ([STATES, _layout(NAMES)], NAMES),
        ([_layout(["", "", ""])], None),
        # Two lists that contradict each other; the one called after joints counts, if there is only one.
        ([("/arm_controller/a", {"names": NAMES}), ("/arm_controller/b", {"names": OTHER})], None),
        ([("/arm_controller/a", {"joints": NAMES}), ("/arm_controller/b", {"frames": OTHER})], NAMES),
        # A list that changes says nothing.
        ([("/arm_controller/a", {"joints": NAMES}), ("/arm_controller/a", {"joints": OTHER})], None),
    ],
)
def test_a_list_goes_with_the_commands_of_its_controller_alone(messages, found):
    lists = NameLists()
    for topic, message in messages:
        lists.add(topic, topic, message)
    labels = lists.labels([*COLUMNS, "/joint_states.position[base]"])
    assert [labels[column].name for column in COLUMNS if column in labels] == (found or [])


def test_in_the_namespace_of_the_root_only_a_list_by_itself_counts():
    columns = [f"/commands.data[{k}]" for k in range(3)]
    lists = NameLists()
    lists.add(0, *STATES)
    assert not lists.labels(columns)
    lists.add(1, "/joint_names", {"joints": NAMES})
    assert [label.name for label in lists.labels(columns).values()] == NAMES
