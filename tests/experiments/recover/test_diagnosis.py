"""The study of diagnoses."""

from experiments.recover.diagnosis.run import PARTS, key, published, tasks_of


def test_published_diagnoses_are_not_made_again() -> None:
    known, tasks = published(), [t for part in PARTS for t in tasks_of(part, 10)]
    assert len({key(task) for task in tasks}) == len(tasks)
    assert known and set(known) <= {key(task) for task in tasks}
    for task in tasks:
        assert [row["trials"] for row in known.get(key(task), [])] in ([], list(task.trials))
