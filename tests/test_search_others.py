============================= test session starts ==============================
platform linux -- Python 3.11.7, pytest-9.2.0, pluggy-1.7.0 -- /work/main/.venv/bin/python
cachedir: .pytest_cache
hypothesis profile 'default'
rootdir: /tmp/wt/tests1
configfile: pyproject.toml
testpaths: tests
plugins: xdist-3.8.0, hypothesis-6.170.17
collecting ... collected 428 items / 12 errors

==================================== ERRORS ====================================
_________________ ERROR collecting tests/robots/test_hands.py __________________
ImportError while importing test module '/tmp/wt/tests1/tests/robots/test_hands.py'.
Hint: make sure your test modules/packages have valid Python names.
Traceback:
/root/.pyenv/versions/3.11.7/lib/python3.11/importlib/__init__.py:126: in import_module
    return _bootstrap._gcd_import(name[level:], package, level)
           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
tests/robots/test_hands.py:7: in <module>
    from tatamu.results import describe_manipulation
E   ModuleNotFoundError: No module named 'tatamu.results'
____________ ERROR collecting tests/robots/test_own_disturbances.py ____________
ImportError while importing test module '/tmp/wt/tests1/tests/robots/test_own_disturbances.py'.
Hint: make sure your test modules/packages have valid Python names.
Traceback:
/root/.pyenv/versions/3.11.7/lib/python3.11/importlib/__init__.py:126: in import_module
    return _bootstrap._gcd_import(name[level:], package, level)
           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
tests/robots/test_own_disturbances.py:14: in <module>
    from tatamu.cli.learning import LearnOptions
E   ModuleNotFoundError: No module named 'tatamu.cli.learning'
_______________ ERROR collecting tests/robots/test_placement.py ________________
ImportError while importing test module '/tmp/wt/tests1/tests/robots/test_placement.py'.
Hint: make sure your test modules/packages have valid Python names.
Traceback:
/root/.pyenv/versions/3.11.7/lib/python3.11/importlib/__init__.py:126: in import_module
    return _bootstrap._gcd_import(name[level:], package, level)
           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
tests/robots/test_placement.py:6: in <module>
    from tatamu.results import ManipulationDescription
E   ModuleNotFoundError: No module named 'tatamu.results'
______________ ERROR collecting tests/robots/test_plan_command.py ______________
ImportError while importing test module '/tmp/wt/tests1/tests/robots/test_plan_command.py'.
Hint: make sure your test modules/packages have valid Python names.
Traceback:
/root/.pyenv/versions/3.11.7/lib/python3.11/importlib/__init__.py:126: in import_module
    return _bootstrap._gcd_import(name[level:], package, level)
           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
tests/robots/test_plan_command.py:13: in <module>
    from tatamu.results import Sources, keep_inputs
E   ModuleNotFoundError: No module named 'tatamu.results'
_______________ ERROR collecting tests/robots/test_rehearsal.py ________________
ImportError while importing test module '/tmp/wt/tests1/tests/robots/test_rehearsal.py'.
Hint: make sure your test modules/packages have valid Python names.
Traceback:
/root/.pyenv/versions/3.11.7/lib/python3.11/importlib/__init__.py:126: in import_module
    return _bootstrap._gcd_import(name[level:], package, level)
           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
tests/robots/test_rehearsal.py:12: in <module>
    from tatamu.learning import learn_job
E   ModuleNotFoundError: No module named 'tatamu.learning'
__________________ ERROR collecting tests/test_benchmarks.py ___________________
ImportError while importing test module '/tmp/wt/tests1/tests/test_benchmarks.py'.
Hint: make sure your test modules/packages have valid Python names.
Traceback:
/root/.pyenv/versions/3.11.7/lib/python3.11/importlib/__init__.py:126: in import_module
    return _bootstrap._gcd_import(name[level:], package, level)
           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
tests/test_benchmarks.py:17: in <module>
    from studies.real_cloth.registry import TESTS
studies/real_cloth/registry.py:9: in <module>
    from studies.real_cloth.towel import Towel
studies/real_cloth/towel.py:18: in <module>
    from tatamu.disturbances.verdict import outcome_in
E   ModuleNotFoundError: No module named 'tatamu.disturbances.verdict'
______________ ERROR collecting tests/test_blender_robustness.py _______________
ImportError while importing test module '/tmp/wt/tests1/tests/test_blender_robustness.py'.
Hint: make sure your test modules/packages have valid Python names.
Traceback:
/root/.pyenv/versions/3.11.7/lib/python3.11/importlib/__init__.py:126: in import_module
    return _bootstrap._gcd_import(name[level:], package, level)
           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
tests/test_blender_robustness.py:18: in <module>
    from tatamu.learning import learn
E   ModuleNotFoundError: No module named 'tatamu.learning'
___________________ ERROR collecting tests/test_cli_learn.py ___________________
ImportError while importing test module '/tmp/wt/tests1/tests/test_cli_learn.py'.
Hint: make sure your test modules/packages have valid Python names.
Traceback:
/root/.pyenv/versions/3.11.7/lib/python3.11/importlib/__init__.py:126: in import_module
    return _bootstrap._gcd_import(name[level:], package, level)
           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
tests/test_cli_learn.py:16: in <module>
    from tatamu.learning import Progress, learn_job
E   ModuleNotFoundError: No module named 'tatamu.learning'
____________________ ERROR collecting tests/test_cluster.py ____________________
ImportError while importing test module '/tmp/wt/tests1/tests/test_cluster.py'.
Hint: make sure your test modules/packages have valid Python names.
Traceback:
/root/.pyenv/versions/3.11.7/lib/python3.11/importlib/__init__.py:126: in import_module
    return _bootstrap._gcd_import(name[level:], package, level)
           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
tests/test_cluster.py:21: in <module>
    from studies.real_cloth.__main__ import app
studies/real_cloth/__main__.py:24: in <module>
    from studies.real_cloth.study import load, run, simulations
studies/real_cloth/study.py:11: in <module>
    from studies.real_cloth.registry import TESTS
studies/real_cloth/registry.py:9: in <module>
    from studies.real_cloth.towel import Towel
studies/real_cloth/towel.py:18: in <module>
    from tatamu.disturbances.verdict import outcome_in
E   ModuleNotFoundError: No module named 'tatamu.disturbances.verdict'
__________________ ERROR collecting tests/test_crosscheck.py ___________________
ImportError while importing test module '/tmp/wt/tests1/tests/test_crosscheck.py'.
Hint: make sure your test modules/packages have valid Python names.
Traceback:
/root/.pyenv/versions/3.11.7/lib/python3.11/importlib/__init__.py:126: in import_module
    return _bootstrap._gcd_import(name[level:], package, level)
           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
tests/test_crosscheck.py:12: in <module>
    from tatamu.learning import learn
E   ModuleNotFoundError: No module named 'tatamu.learning'
_________________ ERROR collecting tests/test_disturbances.py __________________
ImportError while importing test module '/tmp/wt/tests1/tests/test_disturbances.py'.
Hint: make sure your test modules/packages have valid Python names.
Traceback:
/root/.pyenv/versions/3.11.7/lib/python3.11/importlib/__init__.py:126: in import_module
    return _bootstrap._gcd_import(name[level:], package, level)
           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
tests/test_disturbances.py:13: in <module>
    from tatamu.disturbances import (
E   ImportError: cannot import name 'CALM' from 'tatamu.disturbances' (/tmp/wt/tests1/src/tatamu/disturbances/__init__.py)
_____________________ ERROR collecting tests/test_docs.py ______________________
ImportError while importing test module '/tmp/wt/tests1/tests/test_docs.py'.
Hint: make sure your test modules/packages have valid Python names.
Traceback:
/root/.pyenv/versions/3.11.7/lib/python3.11/importlib/__init__.py:126: in import_module
    return _bootstrap._gcd_import(name[level:], package, level)
           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
tests/test_docs.py:15: in <module>
    from studies.real_cloth.__main__ import app as real_cloth
studies/real_cloth/__main__.py:24: in <module>
    from studies.real_cloth.study import load, run, simulations
studies/real_cloth/study.py:11: in <module>
    from studies.real_cloth.registry import TESTS
studies/real_cloth/registry.py:9: in <module>
    from studies.real_cloth.towel import Towel
studies/real_cloth/towel.py:18: in <module>
    from tatamu.disturbances.verdict import outcome_in
E   ModuleNotFoundError: No module named 'tatamu.disturbances.verdict'
!!!!!!!!!!!!!!!!!!!!!!!!!! stopping after 12 failures !!!!!!!!!!!!!!!!!!!!!!!!!!
============================= 12 errors in 35.85s ==============================
